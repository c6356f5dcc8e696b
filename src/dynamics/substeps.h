// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/integrator.h"
#include "crackle/mechanics/conditions.h"

#include <span>
#include <vector>

namespace crackle::dynamics {

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
