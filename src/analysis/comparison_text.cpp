// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/comparison.h"
#include "crackle/analysis/result_list.h"
#include "crackle/common/quantity_text.h"
#include "crackle/common/text_table.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace crackle::analysis {

namespace {

std::string shown_interval(const Difference& difference, const std::string& format, double factor) {
  return difference.has_no_width ? "all equal"
                                 : shown_range(difference.lower, difference.upper, format, factor);
}

nlohmann::ordered_json json_of(const Difference& difference) {
  return {{"value", difference.value},
          {"lower", difference.lower},
          {"upper", difference.upper},
          {"has_no_width", difference.has_no_width}};
}

nlohmann::ordered_json json_of(const SampleCounts& counts) {
  return {{"n_done", counts.done},
          {"n_undecided", counts.undecided},
          {"n_unbroken", counts.unbroken},
          {"n_failed", counts.failed},
          {"n_left", counts.pending}};
}

}  // namespace

std::string to_text(const Comparison& comparison, const std::string& first, const std::string& second,
                    const input::Sections& sections) {
  std::string text = fmt::format("{} minus {}\n", second, first);
  const double percent = 100 * comparison.confidence;
  if (comparison.are_paired)
    fmt::format_to(std::back_inserter(text), "{} with the same bodies; differences are within pairs\n",
                   count_text(comparison.n_pairs, "pair") + " of samples");
  if (!comparison.note.empty()) text += comparison.note + "\n";
  for (const std::string& remark : comparison.remarks) text += remark + "\n";
  TextTable table{{"", "samples", "first", "second", "difference", fmt::format("{:g} % interval", percent),
                   "p", "of all comparisons"}};
  for (const ComparedResult& result : comparison.results) {
    const ResultInfo& info = result.info;
    const bool is_share = !result.share_of.empty();
    const bool is_censored = result.n_bounds_first + result.n_bounds_second > 0;
    const double a = is_censored ? result.median_first.value : result.mean_first;
    const double b = is_censored ? result.median_second.value : result.mean_second;
    const ShownUnit unit = is_share ? ShownUnit{"%", 100} : info.unit_for(std::max(std::abs(a), std::abs(b)));
    const double factor = unit.factor;
    const std::string format = is_share ? ".0f" : info.format;
    std::string label =
        is_share ? fmt::format("{}: {} [%]", info.label, result.share_of) : std::string(info.label);
    if (!is_share && !unit.name.empty()) label += fmt::format(" [{}]", unit.name);
    const auto add = [&](const std::string& name, const Observation& one, const Observation& other,
                         const Difference& difference, const std::string& p, const std::string& adjusted) {
      table.push_back({name, fmt::format("{}, {}", result.n_first, result.n_second),
                       shown(one, format, factor), shown(other, format, factor),
                       shown(difference.value, format, factor), shown_interval(difference, format, factor), p,
                       adjusted});
    };
    const std::string p = shown_probability(result.probability);
    const std::string adjusted =
        result.same_as.empty() ? shown_probability(result.adjusted) : fmt::format("as {}", result.same_as);
    if (is_censored) {
      add(label + ", median", result.median_first, result.median_second, result.of_medians, p, adjusted);
      continue;
    }
    add(is_share ? label : label + ", mean", {a}, {b}, result.of_means, p, adjusted);
    if (!is_share) add("  median", {}, {}, result.of_medians, "", "");
  }
  const std::vector<input::Section> all_sections = sections.all();
  for (const ComparedPaths& paths : comparison.paths) {
    const std::string n = fmt::format("{}, {}", paths.n_first, paths.n_second);
    table.push_back(
        {fmt::format("paths led by start {}: energy distance [mm]", paths.leading_start), n, "", "",
         shown(paths.distance.value, ".4f", 1e3), "",
         shown_probability(std::isnan(paths.distance.value) ? not_a_number : paths.distance.probability),
         shown_probability(paths.adjusted)});
    for (std::size_t s = 0; s < paths.of_means.size(); ++s)
      table.push_back({fmt::format("  mean {} at {} [mm]", input::coordinate_of(all_sections[s]),
                                   input::name_of(all_sections[s])),
                       "", "", "", shown(paths.of_means[s].value, ".3f", 1e3),
                       shown_interval(paths.of_means[s], ".3f", 1e3), "", ""});
  }
  text += aligned(table);
  fmt::format_to(
      std::back_inserter(text),
      "p: by permutations, of a difference as large were there none. Of all {} comparisons: Westfall "
      "and Young's step-down max-T, so that one below 0.05 is by chance in 5 % of such tables at "
      "most; least p possible: {}. Each interval holds individually, not all at once.\n",
      comparison.n_looks, shown_probability(comparison.least));
  return text;
}

std::string to_json(std::span<const Comparison> comparisons, std::span<const std::string> names,
                    const input::Sections& sections) {
  using Json = nlohmann::ordered_json;
  Json document{{"first", names.front()}, {"sections", Json::array()}, {"comparisons", Json::array()}};
  for (const input::Section& section : sections.all())
    document["sections"].push_back(input::name_of(section));
  for (std::size_t i = 0; i < comparisons.size(); ++i) {
    const Comparison& comparison = comparisons[i];
    Json one{
        {"second", names[i + 1]},        {"paired", comparison.are_paired},     {"note", comparison.note},
        {"n_pairs", comparison.n_pairs}, {"confidence", comparison.confidence}, {"results", Json::array()},
        {"paths", Json::array()}};
    one["notes"] = comparison.remarks;
    one["has_shared_base"] = comparison.has_shared_base;
    one["n_looks"] = comparison.n_looks;
    one["p_least"] = comparison.least;
    one["samples"] = {json_of(comparison.first), json_of(comparison.second)};
    for (const ComparedResult& result : comparison.results) {
      Json entry{{"name", result.info.name},
                 {"label", result.info.label},
                 {"shown_units", result.info.shown_units},
                 {"shown_factor", result.info.shown_factor},
                 {"units", result.share_of.empty() ? result.info.units : "1"},
                 {"share_of", result.share_of},
                 {"n_first", result.n_first},
                 {"n_second", result.n_second},
                 {"n_bounds_first", result.n_bounds_first},
                 {"n_bounds_second", result.n_bounds_second},
                 {"mean_first", result.mean_first},
                 {"mean_second", result.mean_second},
                 {"difference_of_means", json_of(result.of_means)},
                 {"p", result.probability},
                 {"p_adjusted", result.adjusted},
                 {"p_least", result.least},
                 {"same_as", result.same_as}};
      if (result.share_of.empty()) entry["difference_of_medians"] = json_of(result.of_medians);
      if (result.n_bounds_first + result.n_bounds_second > 0) {
        entry["median_first"] = known(result.median_first);
        entry["median_second"] = known(result.median_second);
      }
      one["results"].push_back(std::move(entry));
    }
    for (const ComparedPaths& paths : comparison.paths) {
      Json entry{{"leading_notch", paths.leading_start}, {"n_first", paths.n_first},
                 {"n_second", paths.n_second},           {"energy_distance", paths.distance.value},
                 {"p", paths.distance.probability},      {"p_adjusted", paths.adjusted},
                 {"difference_of_means", Json::array()}};
      for (const Difference& difference : paths.of_means)
        entry["difference_of_means"].push_back(json_of(difference));
      one["paths"].push_back(std::move(entry));
    }
    document["comparisons"].push_back(std::move(one));
  }
  // Folder names need not be valid UTF-8.
  return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace crackle::analysis
