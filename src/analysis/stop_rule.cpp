// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/stop_rule.h"

#include <algorithm>

namespace crackle::analysis {

std::vector<std::size_t> look_schedule(int samples, int min_samples) {
  const auto last = static_cast<std::size_t>(samples);
  std::vector<std::size_t> looks;
  for (auto n = static_cast<std::size_t>(min_samples); n < last; n += (n + 1) / 2) looks.push_back(n);
  looks.push_back(last);
  return looks;
}

bool is_known(const Statistics& statistics, double half_width) {
  const PathStatistics& leader = statistics.leader;
  const double n_least = std::max(2.0, min_reached_share * statistics.n_done);
  bool any = false;
  for (std::size_t p = 0; p < leader.reached.size(); ++p) {
    if (leader.reached[p] < n_least) continue;
    any = true;
    if (!(leader.z_half_width[p] <= half_width)) return false;
  }
  return any;
}

}  // namespace crackle::analysis
