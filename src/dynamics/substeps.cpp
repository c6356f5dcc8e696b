// SPDX-License-Identifier: GPL-3.0-or-later
#include "substeps.h"

namespace crackle::dynamics {

void substeps_of(std::span<const Stage> stages, double time_step, double time, bool force_is_current,
                 std::vector<Substep>& substeps) {
  substeps.clear();
  double elapsed = 0;  // in steps, by the drifts done
  for (const Stage& stage : stages) {
    if (stage.kind == Stage::Kind::kick) {
      Substep& substep = substeps.emplace_back();
      substep.has_force = substep.has_kick = true;
      substep.kick = stage.fraction * time_step;
      substep.kick_time = time + elapsed * time_step;
    } else {
      if (substeps.empty() || substeps.back().has_drift) substeps.emplace_back();
      Substep& substep = substeps.back();
      substep.is_first_drift = elapsed == 0;
      elapsed += stage.fraction;
      substep.has_drift = true;
      substep.drift = stage.fraction * time_step;
      substep.drift_time = time + elapsed * time_step;
    }
  }
  for (Substep& substep : substeps) substep.step = {time, time + time_step};
  if (force_is_current && substeps.front().has_kick) substeps.front().has_force = false;
  substeps.back().keeps_force = !substeps.back().has_drift;
}

}  // namespace crackle::dynamics
