// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/bases.h"
#include "common/index.h"
#include "common/text_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <iterator>
#include <numeric>

namespace crackle::analysis {

std::string to_text(const BasesStatistics& statistics, const input::Sections& sections) {
  const std::size_t n = statistics.seeds.size();
  std::string text = fmt::format(
      "{} bases, of seeds {}: {} samples done, {} failed, {} pending{}\n"
      "Intervals are for the material: of the bases' means, Student's t of {} degrees of freedom.\n",
      n, fmt::join(statistics.seeds, ", "),
      std::accumulate(statistics.n_done.begin(), statistics.n_done.end(), 0), statistics.n_failed,
      statistics.n_pending,
      statistics.n_failed + statistics.n_pending > 0 ? "; failed and pending ones are in no number" : "",
      n - 1);
  if (statistics.n_undecided > 0)
    fmt::format_to(std::back_inserter(text), "{} undecided samples count with what they had reached.\n",
                   statistics.n_undecided);
  if (statistics.n_unbroken > 0)
    fmt::format_to(
        std::back_inserter(text),
        "{} samples did not break: means of loads, times, displacements and work are of those that "
        "broke.\n",
        statistics.n_unbroken);
  if (statistics.n_held > 0)
    fmt::format_to(std::back_inserter(text),
                   "{} samples arrested at their largest load, when the loading ended: means of onset, peak "
                   "load, displacement and work are without them.\n",
                   statistics.n_held);
  TextTable table{{"", "samples", "mean", fmt::format("{:g} % interval", 100 * statistics.confidence),
                   "std within", "std between", "intraclass", "design effect"}};
  for (const MeanOverBases& one : statistics.results) {
    const bool is_share = !one.share_of.empty();
    const ShownUnit unit = is_share ? ShownUnit{"%", 100} : one.info.unit_for(std::abs(one.mean.value));
    const std::string format = is_share                                  ? ".1f"
                               : one.info.reduction == Reduction::counts ? ".2f"
                                                                         : one.info.format;
    std::string label = is_share ? fmt::format("{}: {}", one.info.label, one.share_of) : one.info.label;
    if (one.start >= 0)
      label =
          fmt::format("leader, start {}, {}", one.start, input::name_of(sections.all()[index(one.section)]));
    if (!unit.name.empty()) label += fmt::format(" [{}]", unit.name);
    const std::string n_values = fmt::to_string(one.n_values);
    if (one.is_divided) {
      table.push_back({label, n_values, "groups", "-", "-", "-", "-", "-"});
      continue;
    }
    table.push_back({label, n_values, shown(one.mean.value, format, unit.factor),
                     one.mean.has_no_width ? "all equal"
                                           : shown_range(one.mean.lower, one.mean.upper, format, unit.factor),
                     shown(std::sqrt(one.variance.within), format, unit.factor),
                     shown(std::sqrt(one.variance.between), format, unit.factor),
                     shown(one.variance.intraclass, ".2f"), shown(one.variance.design_effect, ".1f")});
  }
  return text + "\n" + aligned(table) +
         "intraclass: share of the variance between bases; design effect: by how much it makes the variance "
         "of a mean over all samples larger than that of independent ones\n";
}

std::string to_json(const BasesStatistics& statistics, std::span<const std::string> folders,
                    const input::Sections& sections) {
  using Json = nlohmann::ordered_json;
  Json results = Json::array();
  for (const MeanOverBases& one : statistics.results) {
    Json entry{{"name", one.info.name},
               {"label", one.info.label},
               {"units", one.share_of.empty() ? one.info.units : "1"},
               {"share_of", one.share_of},
               {"n_values", one.n_values},
               {"base_means", one.of_base},
               {"mean", one.mean.value},
               {"lower", one.mean.lower},
               {"upper", one.mean.upper},
               {"has_no_width", one.mean.has_no_width},
               {"variance_within", one.variance.within},
               {"variance_between", one.variance.between},
               {"intraclass_correlation", one.variance.intraclass},
               {"design_effect", one.variance.design_effect}};
    if (one.start >= 0) {
      entry["leading_notch"] = one.start;
      entry["section"] = one.section;
      entry["is_divided"] = one.is_divided;
      entry["section_name"] = input::name_of(sections.all()[index(one.section)]);
    }
    results.push_back(std::move(entry));
  }
  const Json document{{"folders", folders},
                      {"seeds", statistics.seeds},
                      {"confidence", statistics.confidence},
                      {"n_done", statistics.n_done},
                      {"n_failed", statistics.n_failed},
                      {"n_left", statistics.n_pending},
                      {"n_undecided", statistics.n_undecided},
                      {"n_unbroken", statistics.n_unbroken},
                      {"n_held", statistics.n_held},
                      {"results", std::move(results)}};
  // Folder names need not be valid UTF-8.
  return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace crackle::analysis
