// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_path.h"
#include "crackle/analysis/path_groups.h"
#include "crackle/analysis/text_table.h"
#include "crackle/common/index.h"
#include "crackle/common/quantity_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

namespace crackle::analysis {

std::string groups_text(const Statistics& statistics, const input::Sections& sections,
                        const ShownUnit& unit) {
  const std::vector<input::Section> all = sections.all();
  const std::string interval = fmt::format("{:g} % interval", 100 * statistics.confidence);
  TextTable table{{"cracks", "leading", "start", "group", "samples", "share [%]", interval, "section",
                   "along", "reached", "mean", "std", "+-"}};
  const auto add = [&](const char* cracks, const RankStatistics& ranks) {
    int number = 0;
    for (std::size_t k = 0; k < ranks.groups.size(); ++k) {
      const PathGroup& group = ranks.groups[k];
      number = k > 0 && ranks.groups[k - 1].row == group.row ? number + 1 : 1;
      for (std::size_t s = 0; s < all.size(); ++s) {
        if (ranks.is_divided[group.row * all.size() + s] == 0) continue;
        table.push_back(
            {cracks, fmt::to_string(ranks.leading_start[group.row]), fmt::to_string(ranks.start[group.row]),
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
             "[{}]; "
             "samples of one way have such a gap at a section in at most {:g} %\n",
             unit.name, 100 * false_division_rate) +
         aligned(table);
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
    n_passing += row.hole_passage == static_cast<std::int32_t>(HolePassage::passes) ? 1 : 0;
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
