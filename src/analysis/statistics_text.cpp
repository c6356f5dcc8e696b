// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/path_groups.h"
#include "analysis/result_list.h"
#include "analysis/statistics.h"
#include "analysis/weibull_fit.h"
#include "common/index.h"
#include "common/quantity_text.h"
#include "common/text_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace crackle::analysis {

namespace {

/// A table of positions at the sections.
class PositionTable {
public:
  /// @param heads of the columns that say whose cracks a row is about
  /// @param last head of a column after the others, if any
  PositionTable(std::vector<std::string> heads, std::span<const input::Section> sections, double factor,
                const std::vector<std::string>& last = {})
      : sections_(sections), factor_(factor), n_left_(heads.size()) {
    for (const char* const head : {"section", "along", "reached", "mean", "std", "+-"})
      heads.emplace_back(head);
    heads.insert(heads.end(), last.begin(), last.end());
    rows_.push_back(std::move(heads));
  }

  std::size_t n_sections() const { return sections_.size(); }
  std::string text() const { return aligned(rows_, n_left_); }

  /// @param cells whose cracks the row is about
  /// @param is_divided the mean of all is no crack's position
  void add(std::vector<std::string> cells, const PathStatistics& paths, std::size_t p, bool is_divided,
           const std::vector<std::string>& last = {}) {
    const input::Section& section = sections_[p % sections_.size()];
    const auto length = [&](double value) { return is_divided ? "-" : shown(value, ".3f", factor_); };
    cells.insert(cells.end(),
                 {input::name_of(section), input::coordinate_of(section), fmt::to_string(paths.reached[p]),
                  is_divided ? "groups" : length(paths.z_mean[p]), length(paths.z_std[p]),
                  !is_divided && are_equal(paths, p) ? "all equal" : length(paths.z_half_width[p])});
    cells.insert(cells.end(), last.begin(), last.end());
    rows_.push_back(std::move(cells));
  }

private:
  /// True if several positions are the same, so that they give no interval.
  static bool are_equal(const PathStatistics& paths, std::size_t p) {
    const double* quantiles = &paths.z_quantile[p * quantile_shares.size()];
    return paths.reached[p] > 1 && quantiles[0] == quantiles[quantile_shares.size() - 1];
  }

  std::span<const input::Section> sections_;
  double factor_;
  std::size_t n_left_;
  TextTable rows_;
};

void add_ranks(PositionTable& table, const char* label, const RankStatistics& ranks,
               const std::vector<std::string>& starts) {
  for (std::size_t p = 0; p < ranks.reached.size(); ++p) {
    if (ranks.reached[p] == 0) continue;
    const std::size_t row = p / table.n_sections();
    table.add({label, starts[index(ranks.leading_start[row])], starts[index(ranks.start[row])]}, ranks, p,
              ranks.is_divided[p] != 0, {fmt::to_string(ranks.counted[p])});
  }
}

/// "notch 0 in 104 samples, notch 1 in 95, none in 1", over the completed samples.
std::string leaders(const Statistics& statistics, std::span<const SampleSummary> samples) {
  std::string text;
  for (int start = 0; start <= statistics.n_starts; ++start) {
    const bool is_none = start == statistics.n_starts;
    const auto n = std::ranges::count_if(samples, [&](const SampleSummary& row) {
      return row.status == SampleStatus::done && row.leading_start == (is_none ? -1 : start);
    });
    if (is_none && n == 0) continue;
    fmt::format_to(std::back_inserter(text), "{}{} in {}", text.empty() ? "" : ", ",
                   is_none ? "none" : statistics.start_names[index(start)], n);
    if (start == 0) text += n == 1 ? " sample" : " samples";
  }
  return text;
}

/// Which samples are transformed.
std::string mapped_samples(const Statistics& statistics) {
  std::string text;
  for (std::size_t start = 0; start < statistics.reference_start.size(); ++start) {
    const auto reference = static_cast<std::size_t>(statistics.reference_start[start]);
    if (reference != start)
      fmt::format_to(std::back_inserter(text),
                     "; samples led by {} are mapped by the body's symmetry, as if {} led",
                     statistics.start_names[start], statistics.start_names[reference]);
  }
  return text;
}

/// Lists the sections that no crack has reached, which have no rows.
void append_unreached(std::string& text, const Statistics& statistics,
                      std::span<const input::Section> sections) {
  std::vector<std::string> names;
  for (std::size_t s = 0; s < sections.size(); ++s) {
    bool is_reached = false;
    for (std::size_t p = s; p < statistics.reached.size(); p += sections.size())
      is_reached = is_reached || statistics.reached[p] > 0;
    if (!is_reached) names.push_back(input::name_of(sections[s]));
  }
  if (!names.empty()) text += fmt::format("\nno crack reaches {}\n", fmt::join(names, ", "));
}

/// True if cracks are followed from their starts, as in plates.
bool follows_cracks(const Statistics& statistics, std::span<const SampleSummary> samples) {
  return statistics.n_starts > 0 && std::ranges::none_of(samples, [](const SampleSummary& row) {
           return row.status == SampleStatus::done && row.pattern < 0;
         });
}

void append_positions(std::string& text, const Statistics& statistics, std::span<const SampleSummary> samples,
                      std::span<const input::Section> sections, const ShownUnit& unit) {
  if (follows_cracks(statistics, samples))
    text += fmt::format("\nleading crack start: {}\n", leaders(statistics, samples));
  const std::string scope = interval_scope(statistics.base, statistics.replicates);
  if (std::ranges::all_of(statistics.reached, [](auto n) { return n == 0; })) {
    text += fmt::format("\n{}\n", scope);
    if (statistics.n_starts == 0 && sections.size() > 0)
      text += "Without crack starts no crack is followed to the sections.\n";
    else if (statistics.n_starts > 0)
      append_unreached(text, statistics, sections);
    return;
  }
  text += fmt::format("\ncrack positions, through-thickness mean [{}]; +- at {:g} % confidence{}\n{}\n",
                      unit.name, 100 * statistics.confidence,
                      statistics.n_looks > 1 ? fmt::format(" over {} tests", statistics.n_looks) : "", scope);
  const auto& starts = statistics.start_names;
  PositionTable by_rank({"cracks", "leading", "start"}, sections, unit.factor, {"of samples"});
  add_ranks(by_rank, "leader", statistics.leader, starts);
  // Where all samples have the same pattern, these rows would repeat those above.
  if (statistics.leader_one_crack.counted != statistics.leader.counted)
    add_ranks(by_rank, "leader, one crack", statistics.leader_one_crack, starts);
  if (statistics.leader_two_cracks.counted != statistics.leader.counted)
    add_ranks(by_rank, "leader, two cracks", statistics.leader_two_cracks, starts);
  add_ranks(by_rank, "follower", statistics.follower, starts);
  text += fmt::format("\nby rank{}\n{}", mapped_samples(statistics), by_rank.text());
  if (statistics.n_starts != 1 || statistics.reached != statistics.leader.reached) {
    PositionTable all({"start"}, sections, unit.factor);
    for (std::size_t p = 0; p < statistics.reached.size(); ++p)
      if (statistics.reached[p] > 0)
        all.add({starts[p / sections.size()]}, statistics, p, statistics.is_divided[p] != 0);
    text += "\nall cracks of the start, leading and following\n" + all.text();
  }
  append_unreached(text, statistics, sections);
}

std::string interval_head(double confidence) {
  return fmt::format("{:g} % interval", 100 * confidence);
}

void append_patterns(std::string& text, const Statistics& statistics) {
  TextTable table{{"pattern", "share [%]", interval_head(statistics.confidence)}};
  for (int k = 0; k < n_patterns; ++k)
    table.push_back({category_name(pattern_categories, k), shown(statistics.pattern_share[k], ".1f", 100),
                     shown_range(statistics.pattern_lower[k], statistics.pattern_upper[k], ".1f", 100)});
  text += "\n" + aligned(table, 1, true);
}

void append_shares(std::string& text, const std::vector<ResultStatistics>& results) {
  for (const ResultStatistics& result : results) {
    if (result.info.reduction != Reduction::shares) continue;
    TextTable table{{result.info.label, "samples"}};
    for (std::size_t k = 0; k < result.counts.size(); ++k)
      table.push_back({category_name(result.info.categories, static_cast<std::int64_t>(k)),
                       fmt::to_string(result.counts[k])});
    text += "\n" + aligned(table);
  }
}

void append_counts(std::string& text, const std::vector<ResultStatistics>& results, double confidence) {
  TextTable table{{"", "mean", "samples with any [%]", interval_head(confidence)}};
  for (const ResultStatistics& result : results)
    if (result.info.reduction == Reduction::counts && result.n_values > 0)
      table.push_back({result.info.label, shown(result.mean, ".2f"),
                       fmt::format("{:.1f}", 100.0 * result.n_any / result.n_values),
                       shown_range(result.share_any.lower, result.share_any.upper, ".1f", 100)});
  if (table.size() > 1) text += "\n" + aligned(table, 1, true);
}

/// The most important result comes first: the peak load, where the onset says little (headline_load).
void put_first(std::vector<ResultStatistics>& results, std::string_view name) {
  const auto of_name = [&](const ResultStatistics& one) { return one.info.name == name; };
  if (name == "peak_load") std::ranges::stable_partition(results, of_name);
}

/// @param with_places show where samples broke first
void append_quantiles(std::string& text, const std::vector<ResultStatistics>& results, bool with_places,
                      double confidence) {
  TextTable table{{"", "min", "25 %", "median", "75 %", "max", "samples",
                   fmt::format("{:g} % of median", 100 * confidence)}};
  for (const ResultStatistics& result : results) {
    const ResultInfo& info = result.info;
    if (info.reduction != Reduction::quantiles || (info.about == About::place && !with_places) ||
        result.n_values == 0)
      continue;
    double largest = 0;
    for (const Observation& one : result.quantiles) largest = std::max(largest, std::abs(one.value));
    const ShownUnit unit = info.unit_for(largest);
    const std::string format = fitting_format(info.format, result.quantiles, unit.factor);
    auto& row = table.emplace_back(1, with_unit(info.label, unit.name));
    for (const Observation& one : result.quantiles) row.push_back(shown(one, format, unit.factor));
    const auto& [lower, upper] = result.of_median;
    const bool are_equal =
        result.quantiles.front().value == result.quantiles.back().value && result.n_bounds == 0;
    row.push_back(fmt::to_string(result.n_values));
    row.push_back(std::isnan(lower.value) ? "too few samples"
                  : are_equal             ? "all equal"
                                          : fmt::format("{} to {}", shown(lower, format, unit.factor),
                                                        shown(upper, format, unit.factor)));
  }
  text += "\n" + aligned(table, 1, true);
}

/// Shares of the crack area in the materials and at the interfaces, over the samples that broke.
void append_parts(std::string& text, const Statistics& statistics, std::span<const SampleSummary> samples) {
  if (statistics.crack_parts.empty()) return;
  TextTable table{{"crack area in [%]", "mean", "min", "max", "samples with any"}};
  for (std::size_t k = 0; k < statistics.crack_parts.size(); ++k) {
    double sum = 0, least = 1, largest = 0;
    int n = 0, n_any = 0;
    for (const SampleSummary& row : samples) {
      if (row.status != SampleStatus::done || k >= row.crack_area_in.size() || !(row.crack_area > 0))
        continue;
      const double share = row.crack_area_in[k] / row.crack_area;
      sum += share;
      least = std::min(least, share);
      largest = std::max(largest, share);
      n_any += share > 0 ? 1 : 0;
      ++n;
    }
    if (n == 0) return;
    table.push_back({statistics.crack_parts[k], shown(sum / n, ".1f", 100), shown(least, ".1f", 100),
                     shown(largest, ".1f", 100), fmt::format("{} of {}", n_any, n)});
  }
  text += "\n" + aligned(table);
}

/// The plane's point and normal: "through (0, 0, 15) mm, normal (0, 0, 1)".
std::string name_of(const input::SectionPlane& plane) {
  const Vector point = 1e3 * plane.point, normal = plane.normal / norm(plane.normal);
  return fmt::format("through ({:.6g}, {:.6g}, {:.6g}) mm, normal ({:.4g}, {:.4g}, {:.4g})", point[0],
                     point[1], point[2], normal[0], normal[1], normal[2]);
}

/// The traces of each start's cracks in the planes; starts that never cross one have no row.
void append_traces(std::string& text, const Statistics& statistics,
                   const std::vector<input::SectionPlane>& planes) {
  const std::size_t n_rows = cracks::n_trace_rows(index(statistics.n_starts));
  if (statistics.traces.size() != planes.size() * n_rows) return;
  for (std::size_t plane = 0; plane < planes.size(); ++plane) {
    const std::span traces = std::span(statistics.traces).subspan(plane * n_rows, n_rows);
    const TraceStatistics& all = traces.back();
    if (all.n_of == 0) continue;
    const auto [along, across] = cracks::axes_along(planes[plane]);
    text += fmt::format("\nplane {} {}: crossed by {} of {} samples, {:g} % interval {} %\n", plane,
                        name_of(planes[plane]), all.n_crossed, all.n_of, 100 * statistics.confidence,
                        shown_range(all.interval.lower, all.interval.upper, ".1f", 100));
    if (all.n_crossed == 0) continue;
    text += fmt::format(
        "traces, with their mean place from that point along ({:.4g}, {:.4g}, {:.4g}) and across, along "
        "({:.4g}, "
        "{:.4g}, {:.4g}); times since the onset\n",
        along[0], along[1], along[2], across[0], across[1], across[2]);
    std::vector<std::string> head{"cracks", "samples"};
    for_each_trace_result([&](const ResultInfo& info, auto) {
      head.insert(head.end(), {with_unit(info.label, info.shown_units), "std", "+-"});
    });
    TextTable table{head};
    for (std::size_t k = 0; k < n_rows; ++k) {
      const bool is_all = k + 1 == n_rows, has_start = k < index(statistics.n_starts);
      // After one row of others, that of all would repeat it.
      if (traces[k].n_crossed == 0 || (is_all && table.size() == 2)) continue;
      auto& row = table.emplace_back();
      row = {is_all      ? "all"
             : has_start ? statistics.start_names[k]
                         : "without a start",
             fmt::to_string(traces[k].n_crossed)};
      std::size_t i = 0;
      for_each_trace_result([&](const ResultInfo& info, auto) {
        const TraceStatistics::Estimate& one = traces[k].results[i++];
        for (const double value : {one.mean, one.std, one.half_width})
          row.push_back(shown(value, info.format, info.shown_factor));
      });
    }
    text += aligned(table);
  }
}

ShownUnit unit_of_masses(double body_mass) {
  return body_mass < 1e-3 ? ShownUnit{"mg", 1e6} : body_mass < 1 ? ShownUnit{"g", 1e3} : ShownUnit{"kg", 1};
}

/// The fragments, if any sample has more than two.
void append_fragments(std::string& text, const Statistics& statistics) {
  const FragmentStatistics& found = statistics.fragments;
  if (found.n_fragmented == 0) return;
  text += fmt::format(
      "\nfragments, without single nodes, which are dust: more than two in {} of {}; +- is the {:g} % "
      "interval of the "
      "mean\n",
      found.n_fragmented, count_text(found.n_of, "sample"), 100 * statistics.confidence);
  TextTable table{{"fragments", "mean", "std", "+-"}};
  std::size_t i = 0;
  const ShownUnit mass = unit_of_masses(found.results.back().mean);
  for_each_fragment_result([&](const ResultInfo& info, auto) {
    const MeanEstimate& one = found.results[i++];
    if (std::string_view(info.name).starts_with("frozen") && !(one.mean > 0)) return;
    const ShownUnit unit = info.units == std::string_view("kg") ? mass : info.unit_for(one.mean);
    auto& row = table.emplace_back();
    row = {with_unit(info.label, unit.name)};
    // The mass of all bodies is the same but for rounding.
    const bool is_constant = one.std < 1e-9 * one.mean;
    for (const double value : {one.mean, is_constant ? 0 : one.std, is_constant ? 0 : one.half_width})
      row.push_back(shown(value, info.format, unit.factor));
  });
  text += aligned(table);
  TextTable numbers{{"fragments of at least", "mean number", "std", "+-"}};
  const std::vector<double> shares = fragment_shares();
  constexpr std::size_t per_decade = 4;
  for (std::size_t k = 0; k + 1 < found.heavier.size(); k += per_decade) {
    // Down to the smallest fragments.
    if (k > 0 && found.heavier[k - per_decade].mean == found.heavier[k].mean && numbers.size() == 2)
      numbers.pop_back();
    auto& row = numbers.emplace_back();
    row = {fmt::format("{:g} % of the mass", 100 * shares[k])};
    for (const double value : {found.heavier[k].mean, found.heavier[k].std, found.heavier[k].half_width})
      row.push_back(shown(value, ".1f"));
  }
  text += "\n" + aligned(numbers);
}

/// Weibull's distribution of the loads, where it is one of strengths.
void append_weibull(std::string& text, const Statistics& statistics, std::span<const SampleSummary> samples) {
  if (!statistics.has_strength_scatter || statistics.replicates > 1) return;
  const std::string interval = interval_head(statistics.confidence);
  TextTable table{{"Weibull's distribution", "modulus", interval, "scale", interval, "broken", "unbroken"}};
  for (const auto& [load, fit] : weibull_fits(samples, statistics.confidence)) {
    const ShownUnit unit = load.unit_for(fit.scale.value);
    table.push_back({with_unit(load.label, unit.name), shown(fit.modulus.value, ".3g"),
                     shown_range(fit.modulus.lower, fit.modulus.upper, ".3g"),
                     shown(fit.scale.value, ".4g", unit.factor),
                     shown_range(fit.scale.lower, fit.scale.upper, ".4g", unit.factor),
                     fmt::to_string(fit.n_broken), fmt::to_string(fit.n_unbroken)});
  }
  if (table.size() > 1) text += "\n" + aligned(table, 1, true);
}

/// Which samples no number below covers, and which it covers although they are unfinished.
void append_left_out(std::string& text, const Statistics& statistics,
                     std::span<const SampleSummary> samples) {
  if (statistics.n_done < statistics.n_needed) text += "failed and pending samples are in no number below\n";
  const auto n_undecided = std::ranges::count_if(samples, is_undecided);
  if (n_undecided > 0)
    fmt::format_to(std::back_inserter(text),
                   "{} undecided: still breaking at the end; all numbers below count what they had reached\n",
                   n_undecided);
  const auto n_unbroken = std::ranges::count_if(samples, is_unbroken);
  if (n_unbroken > 0)
    fmt::format_to(std::back_inserter(text),
                   "{} unbroken: loads count them as stronger than the largest load applied (Kaplan and "
                   "Meier); times, displacements and work below are of those that broke\n",
                   n_unbroken);
  const auto n_held = std::ranges::count_if(samples, is_held);
  if (n_held > 0)
    fmt::format_to(std::back_inserter(text),
                   "{} arrested at {} largest load, when the loading ended: onset and peak load count {} as "
                   "stronger; {} left out of times, displacements and work\n",
                   n_held, n_held == 1 ? "its" : "their", n_held == 1 ? "it" : "them",
                   n_held == 1 ? "it is" : "they are");
}

}  // namespace

ShownUnit unit_of_positions(const PathStatistics& paths) {
  constexpr double least = 0.1;  // so that small deviations remain visible [mm]
  double largest = 0;
  for (const double mean : paths.z_mean)
    if (std::abs(mean) > largest) largest = std::abs(mean);  // false for NaN
  return shown_unit({"mm", 1e3}, "m", largest, least);
}

std::string to_text(const Statistics& statistics, std::span<const SampleSummary> samples,
                    const input::Sections& sections, const Origin& origin) {
  const auto n_failed = std::count_if(samples.begin(), samples.end(), [](const SampleSummary& sample) {
    return sample.status == SampleStatus::failed;
  });
  std::string text;
  for (const std::string& note : origin.notes) text += note + "\n";
  text += fmt::format("{}: {} done, {} failed, {} pending\n", count_text(statistics.n_needed, "sample"),
                      statistics.n_done, n_failed, statistics.n_needed - statistics.n_done - n_failed);
  if (statistics.n_needed < statistics.n_samples) {
    fmt::format_to(std::back_inserter(text), "stopped early: these samples suffice, {} were planned\n",
                   statistics.n_samples);
  }
  append_left_out(text, statistics, samples);
  const ShownUnit unit = unit_of_positions(statistics);
  const std::vector<input::Section> all = sections.all();
  append_positions(text, statistics, samples, all, unit);
  text += groups_text(statistics, sections, unit);
  if (follows_cracks(statistics, samples)) append_patterns(text, statistics);
  auto results = result_statistics(samples, statistics.confidence, origin, statistics.replicates);
  put_first(results, headline_load(samples));
  append_shares(text, results);
  append_counts(text, results, statistics.confidence);
  append_quantiles(text, results, statistics.n_starts == 0, statistics.confidence);
  append_weibull(text, statistics, samples);
  append_parts(text, statistics, samples);
  append_traces(text, statistics, sections.planes);
  append_fragments(text, statistics);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!samples[i].error.empty())
      text += fmt::format("\n{} {}: {}",
                          samples[i].status == SampleStatus::failed ? "failed sample" : "pending sample", i,
                          samples[i].error);
    if (!samples[i].note.empty()) text += fmt::format("\nsample {}: {}", i, samples[i].note);
  }
  if (text.back() != '\n') text += '\n';
  return text;
}

}  // namespace crackle::analysis
