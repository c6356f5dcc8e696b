// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/statistics.h"

#include "analysis/censored_values.h"
#include "analysis/running_statistics.h"
#include "common/index.h"
#include "common/real.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>

namespace crackle::analysis {

std::string interval_scope(input::Base base, int replicates) {
  std::string text =
      base == input::Base::shared
          ? "Intervals hold for this base (one set of mother points), not for the material: another base may "
            "differ by more. Folders of several seeds, given together, show it."
          : fmt::format("Intervals cover the scatter of {}samples, each with its own set of mother points.",
                        replicates > 1 ? "" : "independent ");
  if (replicates > 1)
    text += fmt::format(
        " The {} samples of one draw of the random inputs are not independent: intervals are by whole draws.",
        replicates);
  return text;
}

Statistics make_statistics(std::span<const SampleSummary> samples, int n_starts, int n_sections,
                           double confidence) {
  RunningStatistics running(samples.size(), n_starts, n_sections, confidence);
  for (std::size_t i = 0; i < samples.size(); ++i) running.add(i, samples[i]);
  return running.statistics();
}

Statistics make_statistics(std::span<const SampleSummary> samples, const input::Study& study,
                           std::optional<int> n_needed) {
  RunningStatistics running(study);
  if (n_needed) running.stop_at(static_cast<std::size_t>(*n_needed));
  for (std::size_t i = 0; i < samples.size(); ++i) running.add(i, samples[i]);
  return running.statistics();
}

void leave_out_surplus(const Statistics& statistics, std::size_t first, std::vector<SampleSummary>& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (first + i < static_cast<std::size_t>(statistics.n_needed)) continue;
    rows[i] = empty_summary(statistics.n_starts, statistics.n_sections, SampleStatus::pending);
  }
}

std::vector<ResultStatistics> result_statistics(std::span<const SampleSummary> samples, double confidence,
                                                const Origin& origin, int replicates) {
  std::vector<ResultStatistics> all;
  for_each_result([&](const ResultInfo& info, auto member) {
    if (lacks(origin, info.name)) return;
    const CensoredValues found_values = observations(info, member, samples, replicates);
    const std::vector<double>& values = found_values.value;
    ResultStatistics& found = all.emplace_back();
    found.info = info;
    found.n_values = static_cast<int>(values.size());
    found.n_bounds = found_values.n_bounds();
    for (int k = 0; k < n_categories(info.categories); ++k)
      found.counts.push_back(static_cast<int>(std::ranges::count(values, k)));
    for (std::size_t i = 0; i < quantile_shares.size(); ++i)
      found.quantiles[i] = censored_quantile(found_values, quantile_shares[i]);
    if (values.empty()) return;
    std::vector<double> any;
    for (const double value : values) any.push_back(value > 0 ? 1 : 0);
    found.mean = std::accumulate(values.begin(), values.end(), 0.0) / found.n_values;
    found.of_median = censored_median_interval(found_values, confidence);
    found.n_any = static_cast<int>(std::ranges::count(any, 1.0));
    found.share_any = share_interval(any, found_values.group, confidence);
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
