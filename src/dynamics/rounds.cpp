// SPDX-License-Identifier: GPL-3.0-or-later
#include "rounds.h"

namespace crackle::dynamics {

void rounds_of(std::span<const Stage> stages, double time_step, double time, bool force_is_current,
               std::vector<Round>& rounds) {
  rounds.clear();
  double elapsed = 0;  // in steps, by the drifts done
  for (const Stage& stage : stages) {
    if (stage.kind == Stage::Kind::kick) {
      Round& round = rounds.emplace_back();
      round.has_force = round.has_kick = true;
      round.kick = stage.fraction * time_step;
      round.kick_time = time + elapsed * time_step;
    } else {
      if (rounds.empty() || rounds.back().has_drift) rounds.emplace_back();
      Round& round = rounds.back();
      round.is_first_drift = elapsed == 0;
      elapsed += stage.fraction;
      round.has_drift = true;
      round.drift = stage.fraction * time_step;
      round.drift_time = time + elapsed * time_step;
    }
  }
  if (force_is_current && rounds.front().has_kick) rounds.front().has_force = false;
  rounds.back().keeps_force = !rounds.back().has_drift;
}

}  // namespace crackle::dynamics
