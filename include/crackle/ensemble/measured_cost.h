// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"
#include "crackle/dynamics/stable_step.h"
#include "crackle/geometry/realization.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <string>

namespace crackle::ensemble {

/// What the parts of a sample take on this machine. Seconds are those that one core computes, so that other
/// programs on the machine matter little.
struct MeasuredCost {
  double setup = 0;        ///< operators, strengths, loads and coarse space of a sample [s]
  double first_solve = 0;  ///< equilibrium of the intact body [s]; 0 with start = "rest"
  double next_solve = 0;   ///< after a break [s]; 0 where no load breaks the body
  bool breaks = true;      ///< whether the loads can break the body; taken for granted with start = "rest"
  /// Time of the first break from the start of loading on; infinite where nothing breaks, or with start =
  /// "rest" [s].
  double first_break_time = infinity;
  double phase_start = 0;    ///< what a dynamic phase takes before its first step [s]
  double step = 0;           ///< of a dynamic phase: forces, breaking, energies and outputs [s]
  std::int64_t n_steps = 0;  ///< that were measured
  std::string overload;  ///< why the sample will fail, where the loads at time 0 are above its first break
};

/// Measures them on a realization: the equilibrium of the intact body, one break with the equilibrium after
/// it, and the time loop for as long as given, in the course of breaking. Not collective.
/// @param stable_step the breaking check looks ahead by it, see fracture::TulerButcher::screening_share() [s]
/// @param seconds of the time loop
/// @throws std::runtime_error when the static problem has no solution, or the motion cannot be trusted
MeasuredCost measure_cost(const input::Parameters& parameters, const geometry::Realization& realization,
                          double stable_step, const dynamics::TimeGrid& grid, double seconds);

}  // namespace crackle::ensemble
