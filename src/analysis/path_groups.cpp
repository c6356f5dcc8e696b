// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/path_groups.h"

#include "common/index.h"
#include "common/real.h"
#include "common/text_table.h"
#include "cracks/crack_pattern.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

namespace crackle::analysis {

namespace {

using Members = std::vector<std::size_t>;

/// Number of values, and the gap that at most false_division_rate of normal and of uniform samples exceed, in
/// standard deviations within the parts; by simulation of a million samples (fewer above 40 values).
constexpr std::array<std::pair<double, double>, 16> critical_gaps{{{4, 123.0},
                                                                   {5, 55.6},
                                                                   {6, 35.5},
                                                                   {7, 26.0},
                                                                   {8, 20.8},
                                                                   {10, 15.1},
                                                                   {12, 11.8},
                                                                   {15, 9.10},
                                                                   {20, 6.65},
                                                                   {30, 4.40},
                                                                   {40, 3.62},
                                                                   {60, 3.18},
                                                                   {100, 2.85},
                                                                   {200, 2.52},
                                                                   {500, 2.25},
                                                                   {1000, 2.10}}};

double critical_gap(std::size_t n) {
  const auto size = static_cast<double>(n);
  const auto next = std::ranges::lower_bound(critical_gaps, size, {}, &std::pair<double, double>::first);
  if (next == critical_gaps.end()) return critical_gaps.back().second;
  if (next == critical_gaps.begin()) return next->second;
  const auto& [n_low, low] = *std::prev(next);
  const auto& [n_high, high] = *next;
  const double share = std::log(size / n_low) / std::log(n_high / n_low);
  return std::exp(std::lerp(std::log(low), std::log(high), share));
}

/// Sum of squared deviations from the mean of values whose sums are given.
double deviations(double sum, double squares, double n) {
  return squares - sum * sum / n;
}

/// Mean of finite values; NaN without any.
double average_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::vector<double> positions(const std::vector<std::vector<double>>& paths, const Members& members,
                              std::size_t section) {
  std::vector<double> found;
  for (const std::size_t i : members)
    if (!std::isnan(paths[i][section])) found.push_back(paths[i][section]);
  return found;
}

/// Adds a sample that does not reach the dividing section to the part that is nearer where they differ most.
void place(const std::vector<std::vector<double>>& paths, std::size_t sample,
           const std::array<Members, 2>& divided, std::array<Members, 2>& parts) {
  double widest = 0;
  std::size_t nearer = 2;
  for (std::size_t s = 0; s < paths[sample].size(); ++s) {
    const std::vector<std::vector<double>> here{positions(paths, divided[0], s),
                                                positions(paths, divided[1], s)};
    if (std::isnan(paths[sample][s]) || here[0].empty() || here[1].empty() || !are_apart(here)) continue;
    const double low = average_of(here[0]), high = average_of(here[1]);
    if (std::abs(high - low) <= widest) continue;
    widest = std::abs(high - low);
    nearer = std::abs(paths[sample][s] - low) <= std::abs(paths[sample][s] - high) ? 0 : 1;
  }
  if (nearer < 2) parts[nearer].push_back(sample);
}

/// Adds the groups of these samples.
void divide(const std::vector<std::vector<double>>& paths, const Members& members,
            std::vector<Members>& groups) {
  std::optional<Division> clearest;
  std::size_t section = 0;
  for (std::size_t s = 0; s < paths[members.front()].size(); ++s) {
    const auto here = clearest_gap(positions(paths, members, s));
    if (!here || (clearest && here->clarity <= clearest->clarity)) continue;
    clearest = here;
    section = s;
  }
  if (!clearest || clearest->clarity <= 1) {
    groups.push_back(members);
    return;
  }
  std::array<Members, 2> divided;
  for (const std::size_t i : members)
    if (!std::isnan(paths[i][section])) divided[paths[i][section] <= clearest->below ? 0 : 1].push_back(i);
  std::array<Members, 2> parts = divided;
  for (const std::size_t i : members)
    if (std::isnan(paths[i][section])) place(paths, i, divided, parts);
  for (const Members& part : parts) divide(paths, part, groups);
}

}  // namespace

std::optional<Division> clearest_gap(std::vector<double> values) {
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
  if (values.size() < least_for_groups) return std::nullopt;
  const double origin = average_of(values);  // to preserve digits
  const auto n = static_cast<double>(values.size());
  double sum = 0, squares = 0;
  for (const double value : values) {
    sum += value - origin;
    squares += (value - origin) * (value - origin);
  }
  const double critical = critical_gap(values.size());
  std::optional<Division> clearest;
  double sum_below = 0, squares_below = 0;
  for (std::size_t k = 1; k < values.size(); ++k) {
    const double last = values[k - 1] - origin;
    sum_below += last;
    squares_below += last * last;
    const auto n_below = static_cast<double>(k);
    const double within = deviations(sum_below, squares_below, n_below) +
                          deviations(sum - sum_below, squares - squares_below, n - n_below);
    if (!(within > 0)) continue;
    const double weight = std::min({n_below, n - n_below, 2.0});
    const double gap = values[k] - values[k - 1];
    const double clarity = weight * gap / std::sqrt(within / (n - 2)) / critical;
    if (!clearest || clarity > clearest->clarity) clearest = Division{clarity, values[k - 1], values[k]};
  }
  return clearest;
}

bool are_apart(const std::vector<std::vector<double>>& values) {
  std::vector<std::vector<double>> groups = values;
  const auto n_empty = std::erase_if(groups, [](const auto& group) { return group.empty(); });
  if (groups.size() < 2) return groups.size() == 1 && n_empty > 0;
  std::ranges::sort(groups, {}, average_of);
  double squares = 0, n = 0;
  for (const auto& group : groups) {
    const double mean = average_of(group);
    for (const double value : group) squares += (value - mean) * (value - mean);
    n += static_cast<double>(group.size());
  }
  const auto n_groups = static_cast<double>(groups.size());
  const double deviation = n > n_groups ? std::sqrt(squares / (n - n_groups)) : 0;
  for (std::size_t k = 1; k < groups.size(); ++k)
    if (std::ranges::min(groups[k]) - std::ranges::max(groups[k - 1]) <= deviation) return false;
  return true;
}

std::vector<int> path_groups(const std::vector<std::vector<double>>& paths) {
  std::vector<int> group(paths.size(), -1);
  Members members;
  for (std::size_t i = 0; i < paths.size(); ++i)
    if (std::ranges::any_of(paths[i], [](double value) { return !std::isnan(value); })) members.push_back(i);
  if (members.empty()) return group;
  std::vector<Members> groups;
  divide(paths, members, groups);
  for (std::size_t k = 0; k < groups.size(); ++k)
    for (const std::size_t i : groups[k]) group[i] = static_cast<int>(k);
  return group;
}

std::vector<std::uint8_t> divided_sections(const std::vector<std::vector<double>>& paths,
                                           const std::vector<int>& group) {
  std::vector<std::uint8_t> are_divided(paths.empty() ? 0 : paths.front().size(), 0);
  const int n_groups = group.empty() ? 0 : 1 + std::ranges::max(group);
  for (std::size_t s = 0; s < are_divided.size() && n_groups > 1; ++s) {
    std::vector<std::vector<double>> values(index(n_groups));
    for (std::size_t i = 0; i < paths.size(); ++i)
      if (group[i] >= 0 && !std::isnan(paths[i][s])) values[index(group[i])].push_back(paths[i][s]);
    are_divided[s] = are_apart(values) ? 1 : 0;
  }
  return are_divided;
}

std::string groups_text(const Statistics& statistics, const input::Sections& sections,
                        const ShownUnit& unit) {
  const std::vector<input::Section> all = sections.all();
  const std::string interval = fmt::format("{:g} % interval", 100 * statistics.confidence);
  TextTable table{{"cracks", "leading", "start", "group", "samples", "share [%]", interval, "section",
                   "along", "reached", "mean", "std", "+-"}};
  const auto& starts = statistics.start_names;
  const auto add = [&](const char* cracks, const RankStatistics& ranks) {
    int number = 0;
    for (std::size_t k = 0; k < ranks.groups.size(); ++k) {
      const PathGroup& group = ranks.groups[k];
      number = k > 0 && ranks.groups[k - 1].row == group.row ? number + 1 : 1;
      for (std::size_t s = 0; s < all.size(); ++s) {
        if (ranks.is_divided[group.row * all.size() + s] == 0) continue;
        table.push_back(
            {cracks, starts[index(ranks.leading_start[group.row])], starts[index(ranks.start[group.row])],
             fmt::to_string(number), fmt::format("{} of {}", group.n, group.n_of),
             fmt::format("{:.0f}", 100 * group.share),
             shown_range(group.share_lower, group.share_upper, ".0f", 100), input::name_of(all[s]),
             input::coordinate_of(all[s]), fmt::to_string(group.reached[s]),
             shown(group.z_mean[s], ".3f", unit.factor), shown(group.z_std[s], ".3f", unit.factor),
             shown(group.z_half_width[s], ".3f", unit.factor)});
      }
    }
  };
  add("leader", statistics.leader);
  add("follower", statistics.follower);
  if (table.size() == 1) return "";
  return fmt::format(
             "\npositions in groups with a gap between them, where the mean of all is no crack's position "
             "[{}]; cracks that all take one path show such a gap at a section in at most {:g} % of "
             "ensembles\n",
             unit.name, 100 * false_division_rate) +
         aligned(table, 3);
}

std::string holes_text(std::span<const SampleSummary> samples, const std::vector<std::string>& start_names) {
  std::map<std::int32_t, int> n_leading;
  std::map<std::pair<std::int32_t, std::int32_t>, std::pair<int, int>> met;  ///< by start and hole
  for (const SampleSummary& row : samples) {
    if (row.status != SampleStatus::done || row.leading_start < 0) continue;
    ++n_leading[row.leading_start];
    if (row.hole < 0) continue;
    auto& [n, n_passing] = met[{row.leading_start, row.hole}];
    ++n;
    n_passing += row.hole_passage == static_cast<std::int32_t>(cracks::HolePassage::passes) ? 1 : 0;
  }
  std::string text;
  for (const auto& [key, counts] : met) {
    const auto& [n, n_passing] = counts;
    fmt::format_to(std::back_inserter(text),
                   "{} of {} led by {} run into {}: {} {} on from it, {} {} there\n", n,
                   count_text(n_leading[key.first], "sample"), start_names.at(index(key.first)),
                   start_names.at(index(key.second)), n_passing, n_passing == 1 ? "goes" : "go",
                   n - n_passing, n - n_passing == 1 ? "ends" : "end");
  }
  return text.empty() ? "" : "\n" + text;
}

}  // namespace crackle::analysis
