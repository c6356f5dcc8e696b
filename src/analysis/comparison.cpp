// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/comparison.h"
#include "crackle/analysis/leader_frame.h"
#include "crackle/analysis/sample_results.h"
#include "crackle/analysis/sensitivity.h"
#include "crackle/common/index.h"
#include "crackle/geometry/body.h"
#include "crackle/input/reader.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <set>
#include <string_view>
#include <utility>

namespace crackle::analysis {

namespace {

/// The input lines that determine the bodies of the samples.
std::vector<std::string> settings_of_bodies(const input::Parameters& parameters) {
  std::vector<std::string> settings = input::body_settings(parameters);
  for (std::string& line : input::sample_settings(parameters))
    if (line.starts_with("random[") || line.starts_with("ensemble.")) settings.push_back(std::move(line));
  if (!parameters.mesh.points_digest.empty())
    settings.push_back("mesh.points with digest " + parameters.mesh.points_digest);
  return settings;
}

/// The first line of one list that is missing in the other, such as "mesh.spacing = 3 mm"; or empty.
std::optional<std::string> first_of_one_only(const std::vector<std::string>& one,
                                             const std::vector<std::string>& other) {
  for (const std::string& line : one)
    if (std::ranges::find(other, line) == other.end()) return line;
  return {};
}

bool is_done(const SampleSummary& row) {
  return row.status == SampleStatus::done;
}

/// The values of both ensembles that are not NaN; for pairs, those where neither is NaN.
template <class Value>
TwoSamples values_of(std::span<const SampleSummary> first, std::span<const SampleSummary> second,
                     bool are_paired, const Value& value) {
  TwoSamples samples{{}, {}, are_paired};
  if (are_paired) {
    for (std::size_t i = 0; i < std::min(first.size(), second.size()); ++i) {
      if (!is_done(first[i]) || !is_done(second[i])) continue;
      const double a = value(first[i]), b = value(second[i]);
      if (std::isnan(a) || std::isnan(b)) continue;
      samples.first.push_back(a);
      samples.second.push_back(b);
    }
    return samples;
  }
  const auto take = [&](std::span<const SampleSummary> rows, std::vector<double>& values) {
    for (const SampleSummary& row : rows)
      if (is_done(row) && !std::isnan(value(row))) values.push_back(value(row));
  };
  take(first, samples.first);
  take(second, samples.second);
  return samples;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? not_a_number : sum / static_cast<double>(values.size());
}

/// Compares one number, or the share of one category.
ComparedResult compared(const ResultInfo& info, const std::string& share_of, const TwoSamples& samples,
                        double confidence) {
  ComparedResult result{.info = info, .share_of = share_of};
  result.n_first = static_cast<int>(samples.first.size());
  result.n_second = static_cast<int>(samples.second.size());
  result.mean_first = mean_of(samples.first);
  result.mean_second = mean_of(samples.second);
  if (share_of.empty()) {
    result.of_means = difference_of_means(samples, confidence);
    result.of_medians = difference_of_medians(samples, confidence);
  } else {
    result.of_means = difference_of_shares(samples, confidence);
  }
  result.probability =
      samples.first.empty() || samples.second.empty() ? not_a_number : permutation_probability(samples);
  return result;
}

std::vector<ComparedResult> compare_results(const Compared& first, const Compared& second, bool are_paired,
                                            double confidence) {
  std::vector<ComparedResult> results;
  for_each_result([&](const ResultInfo& info, auto member) {
    const bool is_pattern = std::string_view(info.name) == "pattern";
    if (lacks(first.origin, info.name) || lacks(second.origin, info.name) || !is_of_the_body(info) ||
        info.reduction == Reduction::places || (info.reduction == Reduction::none && !is_pattern))
      return;
    const auto add = [&](const std::string& share_of, const auto& value) {
      const TwoSamples samples = values_of(first.rows, second.rows, are_paired, value);
      // A share of 0 or of 1 on both sides is not counted as a comparison.
      const auto is_one = [](double one) { return one == 1; };
      const auto n_ones =
          std::ranges::count_if(samples.first, is_one) + std::ranges::count_if(samples.second, is_one);
      const auto n = std::ssize(samples.first) + std::ssize(samples.second);
      if (n == 0 || (!share_of.empty() && (n_ones == 0 || n_ones == n))) return;
      results.push_back(compared(info, share_of, samples, confidence));
    };
    if (is_pattern || info.reduction == Reduction::shares) {
      for (int k = 0; k < n_categories(info.categories); ++k)
        add(category_name(info.categories, k),
            [&](const SampleSummary& row) { return row.*member == k ? 1.0 : 0.0; });
    } else if (info.reduction == Reduction::counts) {
      add("any", [&](const SampleSummary& row) { return row.*member > 0 ? 1.0 : 0.0; });
    } else {
      add("", [&](const SampleSummary& row) { return static_cast<double>(row.*member); });
    }
  });
  return results;
}

/// The positions of the leading crack in its own frame.
std::vector<double> leading_path(const LeaderFrame& frame, const SampleSummary& row, int reference) {
  std::vector<double> path(index(frame.n_sections()), not_a_number);
  for (int s = 0; s < frame.n_sections(); ++s) {
    const auto source = frame.source(row.leading_start, reference, s);
    if (!source) continue;
    const double position = row.position[index(source->start * frame.n_sections() + source->section)];
    path[index(s)] = source->extent ? *source->extent - position : position;
  }
  return path;
}

std::vector<ComparedPaths> compare_paths(const Compared& first, const Compared& second, bool are_paired,
                                         double confidence) {
  const LeaderFrame frame(*first.parameters);
  std::vector<ComparedPaths> all;
  for (int start = 0; start < frame.n_starts(); ++start) {
    if (frame.reference()[index(start)] != start) continue;
    const auto leads = [&](const SampleSummary& row) {
      return is_done(row) && row.leading_start >= 0 && frame.reference()[index(row.leading_start)] == start;
    };
    TwoGroupsOfPaths paths{{}, {}, are_paired};
    if (are_paired) {
      for (std::size_t i = 0; i < std::min(first.rows.size(), second.rows.size()); ++i) {
        if (!leads(first.rows[i]) || !leads(second.rows[i])) continue;
        paths.first.push_back(leading_path(frame, first.rows[i], start));
        paths.second.push_back(leading_path(frame, second.rows[i], start));
      }
    } else {
      for (const auto& row : first.rows)
        if (leads(row)) paths.first.push_back(leading_path(frame, row, start));
      for (const auto& row : second.rows)
        if (leads(row)) paths.second.push_back(leading_path(frame, row, start));
    }
    if (paths.first.empty() && paths.second.empty()) continue;
    ComparedPaths& found = all.emplace_back();
    found.leading_start = start;
    found.n_first = static_cast<int>(paths.first.size());
    found.n_second = static_cast<int>(paths.second.size());
    found.distance = energy_distance(paths);
    for (int s = 0; s < frame.n_sections(); ++s) {
      TwoSamples samples{{}, {}, are_paired};
      const auto at = [&](const auto& path) { return path[index(s)]; };
      for (std::size_t i = 0; i < std::max(paths.first.size(), paths.second.size()); ++i) {
        const double a = i < paths.first.size() ? at(paths.first[i]) : not_a_number;
        const double b = i < paths.second.size() ? at(paths.second[i]) : not_a_number;
        if (!std::isnan(a) && !(are_paired && std::isnan(b))) samples.first.push_back(a);
        if (!std::isnan(b) && !(are_paired && std::isnan(a))) samples.second.push_back(b);
      }
      found.of_means.push_back(samples.first.empty() || samples.second.empty()
                                   ? Difference{}
                                   : difference_of_means(samples, confidence));
    }
  }
  return all;
}

void adjust(Comparison& comparison) {
  std::vector<double> probabilities;
  for (const auto& result : comparison.results) probabilities.push_back(result.probability);
  for (const auto& paths : comparison.paths)
    probabilities.push_back(std::isnan(paths.distance.value) ? not_a_number : paths.distance.probability);
  const std::vector<double> adjusted = adjusted_for_comparisons(probabilities);
  std::size_t i = 0;
  for (auto& result : comparison.results) result.adjusted = adjusted[i++];
  for (auto& paths : comparison.paths) paths.adjusted = adjusted[i++];
}

/// "-" if there is none.
std::string shown(double value, std::string_view format) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(fmt::format("{{:{}}}", format)), value);
}

std::string shown_interval(const Difference& difference, double factor, std::string_view format) {
  if (std::isnan(difference.lower)) return "-";
  return fmt::format("{} to {}", shown(factor * difference.lower, format),
                     shown(factor * difference.upper, format));
}

std::string shown_probability(double probability) {
  if (std::isnan(probability)) return "-";
  return probability < 0.001 ? "< 0.001" : fmt::format("{:.3f}", probability);
}

nlohmann::ordered_json json_of(const Difference& difference) {
  return {{"value", difference.value}, {"lower", difference.lower}, {"upper", difference.upper}};
}

}  // namespace

Comparison compare(const Compared& first, const Compared& second, double confidence) {
  Comparison comparison;
  comparison.confidence = confidence;
  const auto one = settings_of_bodies(*first.parameters), other = settings_of_bodies(*second.parameters);
  const auto in_one = first_of_one_only(one, other), in_other = first_of_one_only(other, one);
  comparison.are_paired = !in_one && !in_other;
  const auto note = [&comparison](const std::string& text) {
    comparison.note += comparison.note.empty() ? text : "; " + text;
  };
  if (!comparison.are_paired)
    note(fmt::format("not paired, because the bodies differ: {} in one, {} in the other",
                     in_one.value_or("no such setting"), in_other.value_or("no such setting")));
  for (const std::string& text :
       std::set{note_on_intervals(*first.parameters), note_on_intervals(*second.parameters)})
    if (!text.empty()) note(text);
  for (std::size_t i = 0; i < std::min(first.rows.size(), second.rows.size()); ++i)
    comparison.n_pairs += comparison.are_paired && is_done(first.rows[i]) && is_done(second.rows[i]) ? 1 : 0;
  comparison.results = compare_results(first, second, comparison.are_paired, confidence);
  const auto is_of_the_specimen = [](const std::optional<std::string>& line) {
    return line && line->starts_with("specimen.");
  };
  if (first.parameters->sections.all() != second.parameters->sections.all()) {
    note("paths are not compared, because the sections differ");
  } else if (is_of_the_specimen(in_one) || is_of_the_specimen(in_other)) {
    note("paths are not compared, because the bodies differ");
  } else {
    comparison.paths = compare_paths(first, second, comparison.are_paired, confidence);
  }
  adjust(comparison);
  return comparison;
}

std::string to_text(const Comparison& comparison, const std::string& first, const std::string& second,
                    const input::Sections& sections) {
  std::string text = fmt::format("{} minus {}\n", second, first);
  const double percent = 100 * comparison.confidence;
  if (comparison.are_paired)
    fmt::format_to(std::back_inserter(text),
                   "{} pairs of samples with the same bodies; differences are within pairs\n",
                   comparison.n_pairs);
  if (!comparison.note.empty()) text += comparison.note + "\n";
  std::vector<std::array<std::string, 8>> table{{"", "samples", "first", "second", "difference",
                                                 fmt::format("{:g} % interval", percent), "p",
                                                 "of all comparisons"}};
  for (const ComparedResult& result : comparison.results) {
    const ResultInfo& info = result.info;
    const bool is_share = !result.share_of.empty();
    const ShownUnit unit =
        is_share ? ShownUnit{"%", 100}
                 : info.unit_for(std::max(std::abs(result.mean_first), std::abs(result.mean_second)));
    const double factor = unit.factor;
    const std::string_view format = is_share ? ".0f" : info.format;
    std::string label =
        is_share ? fmt::format("{}: {} [%]", info.label, result.share_of) : std::string(info.label);
    if (!is_share && !unit.name.empty()) label += fmt::format(" [{}]", unit.name);
    const auto add = [&](const std::string& name, double a, double b, const Difference& difference,
                         const std::string& p, const std::string& adjusted) {
      table.push_back({name, fmt::format("{}, {}", result.n_first, result.n_second),
                       shown(factor * a, format), shown(factor * b, format),
                       shown(factor * difference.value, format), shown_interval(difference, factor, format),
                       p, adjusted});
    };
    add(is_share ? label : label + ", mean", result.mean_first, result.mean_second, result.of_means,
        shown_probability(result.probability), shown_probability(result.adjusted));
    if (!is_share) add("  median", not_a_number, not_a_number, result.of_medians, "", "");
  }
  const std::vector<input::Section> all_sections = sections.all();
  for (const ComparedPaths& paths : comparison.paths) {
    const std::string n = fmt::format("{}, {}", paths.n_first, paths.n_second);
    table.push_back(
        {fmt::format("paths led by start {}: energy distance [mm]", paths.leading_start), n, "", "",
         shown(1e3 * paths.distance.value, ".4f"), "",
         shown_probability(std::isnan(paths.distance.value) ? not_a_number : paths.distance.probability),
         shown_probability(paths.adjusted)});
    for (std::size_t s = 0; s < paths.of_means.size(); ++s)
      table.push_back({fmt::format("  mean {} at {} [mm]", input::coordinate_of(all_sections[s]),
                                   input::name_of(all_sections[s])),
                       "", "", "", shown(1e3 * paths.of_means[s].value, ".3f"),
                       shown_interval(paths.of_means[s], 1e3, ".3f"), "", ""});
  }
  std::array<std::size_t, 8> width{};
  for (const auto& row : table)
    for (std::size_t c = 0; c < row.size(); ++c) width[c] = std::max(width[c], row[c].size());
  for (const auto& row : table) {
    std::string line = fmt::format("{:<{}}", row[0], width[0]);
    for (std::size_t c = 1; c < row.size(); ++c) line += fmt::format("  {:>{}}", row[c], width[c]);
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  text +=
      "p: by permutations, of a difference as large were there none. Of all comparisons: Holm's adjustment, "
      "so "
      "that one "
      "below 0.05 is by chance in 5 % of such comparisons at most.\n";
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
    for (const ComparedResult& result : comparison.results) {
      Json entry{{"name", result.info.name},
                 {"label", result.info.label},
                 {"shown_units", result.info.shown_units},
                 {"shown_factor", result.info.shown_factor},
                 {"units", result.share_of.empty() ? result.info.units : "1"},
                 {"share_of", result.share_of},
                 {"n_first", result.n_first},
                 {"n_second", result.n_second},
                 {"mean_first", result.mean_first},
                 {"mean_second", result.mean_second},
                 {"difference_of_means", json_of(result.of_means)},
                 {"p", result.probability},
                 {"p_adjusted", result.adjusted}};
      if (result.share_of.empty()) entry["difference_of_medians"] = json_of(result.of_medians);
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
