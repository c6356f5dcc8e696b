// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/statistics.h"

#include "crackle/analysis/running_statistics.h"
#include "crackle/common/real.h"

#include <cmath>
#include <numeric>

namespace crackle::analysis {

Statistics make_statistics(std::span<const SampleSummary> samples, int n_starts, int n_sections,
                           double confidence) {
  RunningStatistics running(samples.size(), n_starts, n_sections, confidence);
  for (std::size_t i = 0; i < samples.size(); ++i) running.add(i, samples[i]);
  return running.statistics();
}

Statistics make_statistics(std::span<const SampleSummary> samples, const input::Parameters& parameters,
                           std::optional<int> n_needed) {
  RunningStatistics running(parameters);
  if (n_needed) running.stop_at(static_cast<std::size_t>(*n_needed));
  for (std::size_t i = 0; i < samples.size(); ++i) running.add(i, samples[i]);
  Statistics statistics = running.statistics();
  statistics.base = parameters.mesh.base;
  return statistics;
}

void leave_out_surplus(const Statistics& statistics, std::size_t first, std::vector<SampleSummary>& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (first + i < static_cast<std::size_t>(statistics.n_needed)) continue;
    rows[i] = empty_summary(statistics.n_starts, statistics.n_sections, SampleStatus::pending);
  }
}

std::vector<ResultStatistics> result_statistics(std::span<const SampleSummary> samples, double confidence,
                                                const Origin& origin) {
  std::vector<ResultStatistics> all;
  for_each_result([&](const ResultInfo& info, auto member) {
    if (lacks(origin, info.name)) return;
    std::vector<double> values;
    for (const SampleSummary& sample : samples) {
      const auto value = static_cast<double>(sample.*member);
      if (sample.status == SampleStatus::done && !std::isnan(value)) values.push_back(value);
    }
    ResultStatistics& found = all.emplace_back();
    found.info = info;
    found.n_values = static_cast<int>(values.size());
    for (int k = 0; k < n_categories(info.categories); ++k)
      found.counts.push_back(static_cast<int>(std::ranges::count(values, k)));
    for (std::size_t i = 0; i < quantile_shares.size(); ++i)
      found.quantiles[i] = quantile(values, quantile_shares[i]);
    if (values.empty()) return;
    found.mean = std::accumulate(values.begin(), values.end(), 0.0) / found.n_values;
    found.n_any = static_cast<int>(std::ranges::count_if(values, [](double value) { return value > 0; }));
    found.share_any = share_interval(found.n_any, found.n_values, confidence);
  });
  return all;
}

double quantile(std::vector<double> values, double share) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  if (values.empty()) return not_a_number;
  std::sort(values.begin(), values.end());
  const double rank = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(std::floor(rank));
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (rank - static_cast<double>(below)) * (values[above] - values[below]);
}

}  // namespace crackle::analysis
