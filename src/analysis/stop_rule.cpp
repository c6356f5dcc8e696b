// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/stop_rule.h"

#include "crackle/common/real.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace crackle::analysis {

namespace {

constexpr int most_samples = 10'000'000;  ///< upper bound of the search

/// Indices of the leaders' positions that count for the rule.
std::vector<std::size_t> positions_that_count(const Statistics& statistics) {
  const std::vector<std::int32_t>& reached = statistics.leader.reached;
  const double n_least = std::max(2.0, min_reached_share * statistics.n_done);
  std::vector<std::size_t> positions;
  for (std::size_t p = 0; p < reached.size(); ++p)
    if (reached[p] >= n_least) positions.push_back(p);
  return positions;
}

}  // namespace

std::vector<std::size_t> look_schedule(int samples, int min_samples) {
  const auto last = static_cast<std::size_t>(samples);
  std::vector<std::size_t> looks;
  for (auto n = static_cast<std::size_t>(min_samples); n < last; n += (n + 1) / 2) looks.push_back(n);
  looks.push_back(last);
  return looks;
}

std::optional<std::size_t> least_certain(const Statistics& statistics) {
  const std::vector<double>& half_width = statistics.leader.z_half_width;
  std::optional<std::size_t> found;
  for (const std::size_t p : positions_that_count(statistics))
    if (!found || half_width[p] > half_width[*found]) found = p;
  return found;
}

double n_samples_needed(const Statistics& statistics, double half_width) {
  const double confidence = confidence_of_look(statistics.confidence, statistics.n_looks);
  double n_needed = not_a_number;
  for (const std::size_t p : positions_that_count(statistics)) {
    const double deviation = statistics.leader.z_std[p];
    // Samples of one draw are alike.
    const double design = deviation > 0 && statistics.replicates > 1
                              ? statistics.leader.z_half_width[p] /
                                    student_half_width(deviation, statistics.leader.reached[p], confidence)
                              : 1;
    int n = 2;  // values at this section
    while (design * student_half_width(deviation, n, confidence) > half_width && n < most_samples)
      n = std::max(n + 1, static_cast<int>(1.02 * n));
    n_needed = std::fmax(n_needed, static_cast<double>(n) * statistics.n_done / statistics.leader.reached[p]);
  }
  return n_needed;
}

bool is_known(const Statistics& statistics, double half_width) {
  const auto worst = least_certain(statistics);
  return worst && statistics.leader.z_half_width[*worst] <= half_width;
}

}  // namespace crackle::analysis
