// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/first_break_prediction.h"
#include "crackle/fracture/material_field.h"
#include "crackle/geometry/realization.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <optional>
#include <stdexcept>

namespace crackle::ensemble {

/// Measured costs of the parts of a sample on this machine, in seconds of CPU time of one core, so that other
/// load on the machine matters little.
struct MeasuredCost {
  double setup = 0;        ///< operators, strengths, loads and coarse space of a sample [s]
  double first_solve = 0;  ///< equilibrium of the intact body [s]; 0 with start = "rest"
  double next_solve = 0;   ///< equilibrium after a break [s]; 0 if no load breaks the body
  /// Stresses and energy of the first equilibrium, with [[initial.stress]].
  std::optional<dynamics::StressState> initial = {};
  double share_at_start = 0;    ///< of stress in strength at time 0, the largest; for quasi-static loading
  fracture::BodyWaves waves{};  ///< see fracture::slowest_waves
  dynamics::FirstBreakPrediction outlook;  ///< for start = "rest": assumed to break
  double phase_start = 0;                  ///< overhead of a dynamic phase before its first step [s]
  double step = 0;           ///< one step of a dynamic phase: forces, breaking, energies and output [s]
  std::int64_t n_steps = 0;  ///< number of measured steps
};

/// The time loop could not be measured. This does not imply that a sample would fail: the measured body is
/// artificially weakened.
class NotMeasured : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Measures the costs on a realization: the equilibrium of the intact body, one break with the equilibrium
/// after it, and the time loop during fracture for the given time. Not collective.
/// @param seconds of the time loop
/// @throws NotMeasured when the motion is invalid; std::runtime_error for anything that makes a sample fail
///   before it moves: boundary conditions that select no nodes or hold too little, loads at time 0 above the
///   first break, no convergence to equilibrium
MeasuredCost measure_cost(const input::Parameters& parameters, const geometry::Realization& realization,
                          double seconds);

}  // namespace crackle::ensemble
