// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/load_outlook.h"
#include "crackle/geometry/realization.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <stdexcept>

namespace crackle::ensemble {

/// What the parts of a sample take on this machine. Seconds are those that one core computes, so that other
/// programs on the machine matter little.
struct MeasuredCost {
  double setup = 0;               ///< operators, strengths, loads and coarse space of a sample [s]
  double first_solve = 0;         ///< equilibrium of the intact body [s]; 0 with start = "rest"
  double next_solve = 0;          ///< after a break [s]; 0 where no load breaks the body
  dynamics::LoadOutlook outlook;  ///< of a sample that starts from rest: taken to break
  double phase_start = 0;         ///< what a dynamic phase takes before its first step [s]
  double step = 0;                ///< of a dynamic phase: forces, breaking, energies and outputs [s]
  std::int64_t n_steps = 0;       ///< that were measured
};

/// The time loop could not be measured. A sample need not fail for that: what is measured is weakened.
class NotMeasured : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Measures them on a realization: the equilibrium of the intact body, one break with the equilibrium after
/// it, and the time loop for as long as given, in the course of breaking. Not collective.
/// @param seconds of the time loop
/// @throws NotMeasured for a motion that cannot be trusted; std::runtime_error for what makes a sample fail
///   before it moves: conditions without a place or that hold too little, loads at time 0 above the first
///   break, an equilibrium that is not found
MeasuredCost measure_cost(const input::Parameters& parameters, const geometry::Realization& realization,
                          double seconds);

}  // namespace crackle::ensemble
