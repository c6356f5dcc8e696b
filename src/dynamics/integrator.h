// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/model.h"
#include "mechanics/conditions.h"

#include <span>
#include <vector>

namespace crackle::dynamics {

/// One stage of a splitting step: a momentum update by the force ("kick") or a displacement update by the
/// velocity ("drift").
struct Stage {
  enum class Kind { kick, drift } kind;
  double fraction;  ///< of the time step
};

/// A symplectic integrator: the stages of its even and odd steps.
struct Splitting {
  std::span<const Stage> even;
  std::span<const Stage> odd;
  double stability_limit;  ///< largest stable omega_max dt
  int steps_per_cycle;     ///< a run is a whole number of cycles
  double forces_per_step;  ///< force evaluations per step, counting those shared by adjacent stages once
};

/// bilateral4: the fourth-order map of McLachlan and Atela (1992) alternating with its adjoint (Casetti
/// 1995), stable up to the pair's unstable pocket at omega dt = 1.570. verlet: kick-drift-kick of order 2,
/// stable below 2.
const Splitting& splitting(input::Integrator integrator);

/// One force evaluation with the following kick and drift; any part may be missing.
struct Substep {
  bool has_force = false;
  bool has_kick = false;
  bool has_drift = false;
  bool is_first_drift = false;  ///< of its step
  bool keeps_force = false;     ///< for the next step, which starts with a kick at the same displacement
  double kick = 0;              ///< duration [s]
  double kick_time = 0;
  double drift = 0;       ///< duration [s]
  double drift_time = 0;  ///< at its end
  mechanics::StepSpan step;
};

/// Splits the stages of one step into substeps, which replace the contents of `substeps`.
/// @param time of the load curves at the beginning of the step [s]
/// @param force_is_current the first kick needs no new force
void substeps_of(std::span<const Stage> stages, double time_step, double time, bool force_is_current,
                 std::vector<Substep>& substeps);

}  // namespace crackle::dynamics
