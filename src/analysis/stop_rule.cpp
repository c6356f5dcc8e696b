// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/stop_rule.h"

#include "common/real.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace crackle::analysis {

namespace {

constexpr int most_samples = 10'000'000;  ///< upper bound of the search

/// The leaders' means that count for the rule.
std::vector<LeaderMean> means_that_count(const Statistics& statistics) {
  const RankStatistics& leader = statistics.leader;
  const double n_least = std::max(2.0, min_reached_share * statistics.n_done);
  std::vector<LeaderMean> means;
  const auto add = [&](std::size_t position, const PathStatistics& paths, std::size_t p,
                       const PathGroup* group) {
    if (paths.reached[p] >= n_least)
      means.push_back({position, group, paths.reached[p], paths.z_std[p], paths.z_half_width[p]});
  };
  for (std::size_t p = 0; p < leader.reached.size(); ++p) {
    if (leader.is_divided[p] == 0) add(p, leader, p, nullptr);
    const auto n_sections = static_cast<std::size_t>(statistics.n_sections);
    for (const PathGroup& group : leader.groups)
      if (leader.is_divided[p] != 0 && group.row == p / n_sections && group.share >= min_group_share)
        add(p, group, p % n_sections, &group);
  }
  return means;
}

}  // namespace

std::vector<std::size_t> look_schedule(int samples, int min_samples) {
  const auto last = static_cast<std::size_t>(samples);
  std::vector<std::size_t> looks;
  for (auto n = static_cast<std::size_t>(min_samples); n < last; n += (n + 1) / 2) looks.push_back(n);
  looks.push_back(last);
  return looks;
}

std::optional<LeaderMean> least_certain(const Statistics& statistics) {
  // Samples of a single draw give no half width.
  const auto width = [](const LeaderMean& mean) {
    return std::isnan(mean.half_width) ? infinity : mean.half_width;
  };
  std::optional<LeaderMean> found;
  for (const LeaderMean& mean : means_that_count(statistics))
    if (!found || width(mean) > width(*found)) found = mean;
  return found;
}

double n_samples_needed(const Statistics& statistics, double half_width) {
  const double confidence = confidence_of_look(statistics.confidence, statistics.n_looks);
  double n_needed = not_a_number;
  for (const LeaderMean& mean : means_that_count(statistics)) {
    if (std::isnan(mean.half_width)) return not_a_number;
    // Samples of one draw are alike.
    const double design = mean.deviation > 0 && statistics.replicates > 1
                              ? mean.half_width / student_half_width(mean.deviation, mean.n, confidence)
                              : 1;
    int n = 2;  // values at this section
    while (design * student_half_width(mean.deviation, n, confidence) > half_width && n < most_samples)
      n = std::max(n + 1, static_cast<int>(1.02 * n));
    n_needed = std::fmax(n_needed, static_cast<double>(n) * statistics.n_done / mean.n);
  }
  return n_needed;
}

bool is_known(const Statistics& statistics, double half_width) {
  const auto worst = least_certain(statistics);
  return worst && worst->half_width <= half_width;
}

}  // namespace crackle::analysis
