// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/path_groups.h"
#include "crackle/analysis/sample_results.h"
#include "crackle/analysis/statistics.h"
#include "crackle/analysis/text_table.h"
#include "crackle/common/index.h"
#include "crackle/common/quantity_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace crackle::analysis {

namespace {

/// A number, or a dash if there is none.
std::string number(double value, int decimals) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, decimals);
}

/// The largest magnitude among numbers; 0 without any.
double largest_size(std::span<const double> values) {
  double largest = 0;
  for (const double value : values)
    if (std::abs(value) > largest) largest = std::abs(value);  // false for NaN
  return largest;
}

/// The columns that identify the section in a table of positions.
class SectionColumns {
public:
  /// @param unit of positions
  SectionColumns(std::span<const input::Section> sections, ShownUnit unit) : unit_(std::move(unit)) {
    for (const input::Section& section : sections) {
      names_.emplace_back(input::name_of(section), input::coordinate_of(section));
      name_width_ = std::max(name_width_, names_.back().first.size());
      coordinate_width_ = std::max(coordinate_width_, names_.back().second.size());
    }
  }

  std::size_t size() const { return names_.size(); }
  const std::string& unit() const { return unit_.name; }
  const std::string& name(std::size_t section) const { return names_[section].first; }

  std::string heads() const {
    return cells("section", "along") + "  reached       mean        std         +-";
  }

  /// One line of a table of positions.
  /// @param is_divided the mean of all is no crack's position
  void append_position(std::string& text, const PathStatistics& paths, std::size_t p,
                       bool is_divided = false) const {
    const double factor = unit_.factor;
    const auto& [name, coordinate] = names_[p % names_.size()];
    fmt::format_to(std::back_inserter(text), "{} {:>8} {:>10} {:>10} {:>10}", cells(name, coordinate),
                   paths.reached[p], is_divided ? "groups" : number(paths.z_mean[p] * factor, 3),
                   is_divided ? "-" : number(paths.z_std[p] * factor, 3),
                   is_divided            ? "-"
                   : are_equal(paths, p) ? "all equal"
                                         : number(paths.z_half_width[p] * factor, 3));
  }

private:
  /// True if several positions are the same, so that they give no interval.
  static bool are_equal(const PathStatistics& paths, std::size_t p) {
    const double* quantiles = &paths.z_quantile[p * quantile_shares.size()];
    return paths.reached[p] > 1 && quantiles[0] == quantiles[quantile_shares.size() - 1];
  }
  std::string cells(const std::string& name, const std::string& coordinate) const {
    return fmt::format(" {:>{}} {:>{}}", name, name_width_, coordinate, coordinate_width_);
  }

  ShownUnit unit_;
  std::vector<std::pair<std::string, std::string>> names_;  ///< of the section and of its coordinate
  std::size_t name_width_ = 14;
  std::size_t coordinate_width_ = 5;
};

void append_ranks(std::string& text, const char* label, const RankStatistics& ranks,
                  const SectionColumns& sections) {
  for (std::size_t p = 0; p < ranks.reached.size(); ++p) {
    if (ranks.reached[p] == 0) continue;
    const std::size_t row = p / sections.size();
    fmt::format_to(std::back_inserter(text), "{:<18} {:>7} {:>5}", label, ranks.leading_start[row],
                   ranks.start[row]);
    sections.append_position(text, ranks, p, ranks.is_divided[p] != 0);
    fmt::format_to(std::back_inserter(text), " {:>10}\n", ranks.counted[p]);
  }
}

/// True if the cracks of a start take several ways where they lead or follow.
/// @param p index of start and section
bool is_divided(const Statistics& statistics, std::size_t p) {
  const auto n_sections = static_cast<std::size_t>(statistics.n_sections);
  const auto in = [&](const RankStatistics& ranks) {
    for (std::size_t row = 0; row < ranks.start.size(); ++row)
      if (static_cast<std::size_t>(ranks.start[row]) == p / n_sections &&
          ranks.is_divided[row * n_sections + p % n_sections] != 0)
        return true;
    return false;
  };
  return in(statistics.leader) || in(statistics.follower);
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
void append_unreached(std::string& text, const Statistics& statistics, const SectionColumns& sections) {
  std::vector<std::string> names;
  for (std::size_t s = 0; s < sections.size(); ++s) {
    bool is_reached = false;
    for (std::size_t p = s; p < statistics.reached.size(); p += sections.size())
      is_reached = is_reached || statistics.reached[p] > 0;
    if (!is_reached) names.push_back(sections.name(s));
  }
  if (!names.empty()) text += fmt::format("\nno crack reaches {}\n", fmt::join(names, ", "));
}

void append_positions(std::string& text, const Statistics& statistics, std::span<const SampleSummary> samples,
                      const SectionColumns& sections) {
  auto out = std::back_inserter(text);
  if (statistics.n_starts > 0)
    fmt::format_to(out, "\nleading crack start: {}\n", leaders(statistics, samples));
  if (std::ranges::all_of(statistics.reached, [](auto n) { return n == 0; })) {
    fmt::format_to(out, "\n{}\n", interval_scope(statistics.base, statistics.replicates));
    if (statistics.n_starts == 0)
      text += "Without crack starts no crack is followed to the sections.\n";
    else
      append_unreached(text, statistics, sections);
    return;
  }
  fmt::format_to(out, "\ncrack positions, through-thickness mean [{}]; +- at {:g} % confidence{}\n",
                 sections.unit(), 100 * statistics.confidence,
                 statistics.n_looks > 1 ? fmt::format(" over {} tests", statistics.n_looks) : "");
  fmt::format_to(out, "{}\n", interval_scope(statistics.base, statistics.replicates));
  fmt::format_to(out, "\nby rank{}\n{:<18} {:>7} {:>5}{} {:>10}\n", mapped_samples(statistics), "cracks",
                 "leading", "start", sections.heads(), "of samples");
  append_ranks(text, "leader", statistics.leader, sections);
  // Where all samples have the same pattern, these rows would repeat those above.
  if (statistics.leader_one_crack.counted != statistics.leader.counted)
    append_ranks(text, "leader, one crack", statistics.leader_one_crack, sections);
  if (statistics.leader_two_cracks.counted != statistics.leader.counted)
    append_ranks(text, "leader, two cracks", statistics.leader_two_cracks, sections);
  append_ranks(text, "follower", statistics.follower, sections);
  if (statistics.n_starts == 1 && statistics.reached == statistics.leader.reached)
    return append_unreached(text, statistics, sections);
  fmt::format_to(out, "\nall cracks of the start, leading and following\nstart{}\n", sections.heads());
  for (std::size_t p = 0; p < statistics.reached.size(); ++p) {
    if (statistics.reached[p] == 0) continue;
    fmt::format_to(out, "{:>5}", p / sections.size());
    sections.append_position(text, statistics, p, is_divided(statistics, p));
    text += '\n';
  }
  append_unreached(text, statistics, sections);
}

void append_patterns(std::string& text, const Statistics& statistics) {
  auto out = std::back_inserter(text);
  fmt::format_to(out, "\npattern        share [%]   {:g} % interval\n", 100 * statistics.confidence);
  for (int k = 0; k < n_patterns; ++k) {
    fmt::format_to(out, "{:<12} {:>11}   {} to {}\n", category_name(pattern_categories, k),
                   number(100 * statistics.pattern_share[k], 1), number(100 * statistics.pattern_lower[k], 1),
                   number(100 * statistics.pattern_upper[k], 1));
  }
}

void append_shares(std::string& text, const std::vector<ResultStatistics>& results) {
  for (const ResultStatistics& result : results) {
    if (result.info.reduction != Reduction::shares) continue;
    auto out = std::back_inserter(text);
    fmt::format_to(out, "\n{:<12}   samples\n", result.info.label);
    for (std::size_t k = 0; k < result.counts.size(); ++k)
      fmt::format_to(out, "{:<14} {:>7}\n",
                     category_name(result.info.categories, static_cast<std::int64_t>(k)), result.counts[k]);
  }
}

void append_counts(std::string& text, const std::vector<ResultStatistics>& results, double confidence) {
  bool is_first = true;
  for (const ResultStatistics& result : results) {
    if (result.info.reduction != Reduction::counts || result.n_values == 0) continue;
    auto out = std::back_inserter(text);
    if (is_first)
      fmt::format_to(out, "\n{:<20} {:>6} {:>24}   {:g} % interval\n", "", "mean", "samples with any [%]",
                     100 * confidence);
    is_first = false;
    fmt::format_to(out, "{:<20} {:>6.2f} {:>24.1f}   {:.1f} to {:.1f}\n", result.info.label, result.mean,
                   100.0 * result.n_any / result.n_values, 100 * result.share_any.lower,
                   100 * result.share_any.upper);
  }
}

/// The most important result comes first: the peak load, where the onset says little (headline_load).
void put_first(std::vector<ResultStatistics>& results, std::string_view name) {
  const auto of_name = [&](const ResultStatistics& one) { return one.info.name == name; };
  if (name == "peak_load") std::ranges::stable_partition(results, of_name);
}

/// @param with_places show results of type places
void append_quantiles(std::string& text, const std::vector<ResultStatistics>& results, bool with_places,
                      double confidence) {
  fmt::format_to(std::back_inserter(text),
                 "\n{:<30} {:>12} {:>12} {:>12} {:>12} {:>12} {:>8}   {:g} % of median\n", "", "min", "25 %",
                 "median", "75 %", "max", "samples", 100 * confidence);
  for (const ResultStatistics& result : results) {
    const ResultInfo& info = result.info;
    const bool is_shown =
        info.reduction == Reduction::quantiles || (with_places && info.reduction == Reduction::places);
    if (!is_shown || result.n_values == 0) continue;
    auto out = std::back_inserter(text);
    double largest = 0;
    for (const Observation& one : result.quantiles) largest = std::max(largest, std::abs(one.value));
    const ShownUnit unit = info.unit_for(largest);
    fmt::format_to(out, "{:<30}", info.label + (unit.name.empty() ? "" : fmt::format(" [{}]", unit.name)));
    const std::string format = fitting_format(info.format, result.quantiles, unit.factor);
    for (const Observation& one : result.quantiles)
      fmt::format_to(out, " {:>12}", shown(one, format, unit.factor));
    const auto& [lower, upper] = result.of_median;
    fmt::format_to(
        out, " {:>8}   {}\n", result.n_values,
        std::isnan(lower.value) ? "too few samples"
        : result.quantiles.front().value == result.quantiles.back().value && result.n_bounds == 0
            ? "all equal"
            : fmt::format("{} to {}", shown(lower, format, unit.factor), shown(upper, format, unit.factor)));
  }
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
}

}  // namespace

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
  constexpr double least = 0.1;  // of positions, so that small deviations remain visible [mm]
  const ShownUnit unit = shown_unit({"mm", 1e3}, "m", largest_size(statistics.z_mean), least);
  append_positions(text, statistics, samples, SectionColumns(sections.all(), unit));
  text += groups_text(statistics, sections, unit);
  if (statistics.n_starts > 0) append_patterns(text, statistics);
  auto results = result_statistics(samples, statistics.confidence, origin, statistics.replicates);
  put_first(results, headline_load(samples));
  append_shares(text, results);
  append_counts(text, results, statistics.confidence);
  append_quantiles(text, results, statistics.n_starts == 0, statistics.confidence);
  append_parts(text, statistics, samples);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    auto out = std::back_inserter(text);
    if (!samples[i].error.empty())
      fmt::format_to(out, "\n{} {}: {}",
                     samples[i].status == SampleStatus::failed ? "failed sample" : "pending sample", i,
                     samples[i].error);
    if (!samples[i].note.empty()) fmt::format_to(out, "\nsample {}: {}", i, samples[i].note);
  }
  if (text.back() != '\n') text += '\n';
  return text;
}

}  // namespace crackle::analysis
