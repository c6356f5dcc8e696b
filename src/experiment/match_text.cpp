// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/common/quantity_text.h"
#include "crackle/common/text_table.h"
#include "crackle/experiment/matching.h"
#include "text_parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

namespace crackle::experiment {

namespace {

using crackle::aligned;

/// In the unit that suits the largest of those beside it.
std::string size_text(double value, const std::string& unit, double largest) {
  if (std::isnan(value)) return "-";
  return unit == "1" ? fmt::format("{:.2f}", value) : quantity_text(value, unit, 3, largest);
}

std::string place_text(const plane::Point& p) {
  return fmt::format("({}, {})", quantity_text(p[0], "m"), quantity_text(p[1], "m"));
}

std::string samples_text(const Match& match) {
  std::vector<std::string> parts;
  if (!match.failed.empty()) parts.push_back(named(match.failed, "failed"));
  if (!match.undecided.empty()) parts.push_back(named(match.undecided, "undecided"));
  if (!match.missing.empty()) parts.push_back(named(match.missing, "missing"));
  const std::string count = fmt::format("{} of {} samples", match.n_used, match.n_planned);
  return parts.empty() ? count + "\n" : fmt::format("{}; left out: {}\n", count, fmt::join(parts, ", "));
}

std::string nearest_text(const MatchBy& by) {
  std::vector<std::string> parts;
  for (const auto& [sample, distance] : by.nearest)
    parts.push_back(fmt::format("{} ({})", sample, size_text(distance, by.unit, by.mean_distance)));
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string experiments_table(const Match& match) {
  TextTable rows{{"experiment", "by", "p", "distance", "usual", "offset", "std", "nearest samples"}};
  for (const ExperimentMatch& experiment : match.experiments) {
    std::string name = experiment.name;
    for (const MatchBy& by : experiment.by) {
      const double largest = largest_magnitude({by.mean_distance, by.usual_distance, by.offset});
      const auto size = [&](double value) { return size_text(value, by.unit, largest); };
      rows.push_back({std::exchange(name, ""), readable(by.name), shown_probability(by.p_value),
                      size(by.mean_distance), size(by.usual_distance), size(by.offset), size(by.deviation),
                      nearest_text(by)});
    }
  }
  return rows.size() == 1 ? "" : aligned(rows, 2, true);
}

std::string departure_text(const Departure& part, const PathFrame& frame) {
  const std::string between = place_text(part.from) + " to " + place_text(part.to);
  if (std::isnan(part.beyond)) return between + ", where it has ended";
  return fmt::format("{}, by up to {} in {}", between, quantity_text(part.beyond, "m", 3),
                     frame.is_along_y ? "y" : "z");
}

std::string path_text(const PathMatch& path) {
  if (std::ranges::all_of(path.offset, [](double offset) { return std::isnan(offset); }))
    return "its path does not run along those of the samples; if it should, check origin, angle and mirror";
  const std::string band = fmt::format("the samples' {:.3g} % band", 100 * path.band.level);
  if (path.departures.empty()) return fmt::format("its path stays within {}", band);
  std::vector<std::string> parts;
  for (const Departure& part : path.departures) parts.push_back(departure_text(part, path.frame));
  return fmt::format("its path leaves {} from {}", band, fmt::join(parts, "; from "));
}

std::string remarks(const Match& match) {
  std::string text;
  for (const ExperimentMatch& experiment : match.experiments) {
    if (experiment.path) text += fmt::format("{}: {}.\n", experiment.name, path_text(*experiment.path));
    if (!experiment.note.empty()) text += fmt::format("{}: {}.\n", experiment.name, experiment.note);
  }
  // Most experiments lack the same samples.
  std::vector<std::pair<std::string, std::vector<std::uint64_t>>> told;
  for (const ExperimentMatch& experiment : match.experiments) {
    for (const MatchBy& by : experiment.by) {
      const std::pair lack{by.name, by.left_out};
      if (by.name == "jointly" || by.left_out.empty() || std::ranges::find(told, lack) != told.end())
        continue;
      told.push_back(lack);
      text += fmt::format("Left out by {}, which they lack: {}.\n", readable(by.name),
                          named(by.left_out, by.left_out.size() == 1 ? "sample" : "samples"));
    }
  }
  return text;
}

std::string interval(const analysis::BoundedMean& found, const auto& show) {
  if (std::isnan(found.value)) return "-";
  if (std::isnan(found.lower)) return show(found.value);
  return fmt::format("{} ({} to {})", show(found.value), show(found.lower), show(found.upper));
}

std::string set_text(const SetMatch& set) {
  TextTable rows{{"together by", "experiments", "p", "of energy", "of depth", "shift", "scatter, ratio"}};
  for (const SetMatchBy& by : set.by) {
    const analysis::BoundedMean& shift = by.scatter.shift;
    const double largest = largest_magnitude({shift.value, shift.lower, shift.upper});
    rows.push_back({readable(by.name), fmt::format("{}", by.n_experiments),
                    shown_probability(by.test.p_value()), shown_probability(by.test.energy_p_value),
                    shown_probability(by.test.depth_p_value),
                    interval(shift, [&](double value) { return size_text(value, by.unit, largest); }),
                    interval(by.scatter.ratio, [](double value) { return fmt::format("{:#.2g}", value); })});
  }
  std::string text = aligned(rows, 2, true);
  for (const SetMatchBy& by : set.by) {
    if (by.advice.empty()) continue;
    text += fmt::format("By {}: {}\n", readable(by.name), by.advice);
    if (by.power.n_trials > 0)
      text += fmt::format(
          "  {} experiments and {} samples find a shift of one standard deviation in {}, twice the scatter "
          "in {} of cases.\n",
          by.n_experiments, by.n_samples, shown_percent(by.power.of_shift),
          shown_percent(by.power.of_scatter));
  }
  const GroupTest& test = set.by.back().test;
  return text +
         fmt::format(
             "p: that experiments and samples are of one distribution, by energy distance and by ranks "
             "of depth ({} permutations{}), the smaller one doubled.\n",
             test.n_permutations, test.are_all ? ", all there are" : "");
}

}  // namespace

std::string to_text(const Match& match) {
  std::string text = samples_text(match);
  for (const std::string& warning : match.warnings) text += fmt::format("warning: {}\n", warning);
  if (const std::string table = experiments_table(match); !table.empty()) text += "\n" + table;
  text += remarks(match);
  text += fmt::format(
      "p: the share of samples, the experiment among them, that are as far from all others on average; "
      "{:.2g} at least. Distance: that mean; usual: the samples' median. Offset: from "
      "the samples' mean, along the path on average; std: of the same of the samples.\n",
      least_p_value(match.n_used));
  if (match.set) text += "\n" + set_text(*match.set);
  return text;
}

}  // namespace crackle::experiment
