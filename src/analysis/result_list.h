// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/sample_summary.h"
#include "common/quantity_text.h"
#include "common/text_table.h"

#include <concepts>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

/// The single list of a sample's numerical results. Messages between ranks, result files, `crackle stats`,
/// the report and the table in jobs/results.md are generated from it: a new result needs one member of
/// SampleSummary, one entry here, and the line that computes it. crackle/dynamics/machine_load.h defines
/// load, displacement and separation.
namespace crackle::analysis {

/// What a result tells of.
enum class About {
  body,         ///< how the body broke
  place,        ///< where it began to; known beforehand for bodies with crack starts
  path,         ///< cracks followed from their starts; nothing for bodies without
  hole,         ///< a crack that runs into a hole
  computation,  ///< the quality of the computation
};

/// How a table over all samples summarizes a result.
enum class Reduction {
  none,       ///< nothing
  quantiles,  ///< minimum, quartiles, median, maximum
  counts,     ///< mean, and share of samples with a non-zero value
  shares,     ///< number of samples in each category
};

/// The short tables that show a result, as bits.
enum ShortTable : unsigned {
  nowhere = 0,
  in_watch = 1,          ///< `crackle watch`
  in_sweep = 2,          ///< the cases of a sweep, side by side
  in_sensitivities = 4,  ///< the report's sensitivities to random inputs
};

/// The meaning of a result for a sample that did not break, or that was held (is_held) if the result `tells
/// the end`.
enum class OfUnbroken {
  value,    ///< its value, like any other sample's
  bound,    ///< that it lies above the largest load applied, the sample's peak load (right-censored)
  nothing,  ///< the result describes how samples break
};

/// Metadata of a result.
struct ResultInfo {
  const char* name;     ///< /summary/<name> of a sample file, /samples/<name> of the ensemble's
  const char* units;    ///< SI; "" for counts
  const char* meaning;  ///< one phrase
  About about;
  Reduction reduction;
  unsigned short_tables;        ///< of ShortTable
  const char* label;            ///< column heading for display
  const char* shown_units;      ///< units for display
  double shown_factor;          ///< from SI to shown_units
  const char* format;           ///< of the shown value, in the syntax of fmt and Python
  const char* categories = "";  ///< for a number that encodes a word: "0 none, 1 ..."
  std::int64_t since =
      4;  ///< first version of the file format with this result, from the oldest that is read
  OfUnbroken of_unbroken = OfUnbroken::value;
  bool is_start = false;       ///< the number of a crack start, or -1
  bool tells_the_end = false;  ///< it would change if a held sample were loaded further

  /// True for numbers that stand for a word or a crack start: these have shares, no mean.
  bool is_nominal() const { return *categories != 0 || is_start; }

  /// The display unit for values up to this size; the same for bodies of millimetres.
  ShownUnit unit_for(double largest) const { return shown_unit({shown_units, shown_factor}, units, largest); }
};

/// Words for SampleStatus, as stored in the files.
inline constexpr const char* status_categories = "0 pending, 1 done, 2 failed";

/// Names of the values of Pattern.
inline constexpr const char* pattern_categories = "0 none, 1 one crack, 2 two cracks, 3 other";

/// Names of the values of HolePassage.
inline constexpr const char* passage_categories = "0 no hole, 1 ends there, 2 goes on";

/// Calls visit(info, member) for every scalar result of a sample, in the order of tables and messages.
template <class Visit>
void for_each_result(Visit&& visit) {
  using Row = SampleSummary;
  using enum About;
  using enum Reduction;
  visit(ResultInfo{"first_break_time", "s", "load time of the first break", body, quantiles, nowhere,
                   "first break time", "s", 1, ".6f", "", 4, OfUnbroken::nothing},
        &Row::first_break_time);
  visit(ResultInfo{"first_break_x", "m", "position of the first break across the thickness", place, quantiles,
                   nowhere, "first break at x", "mm", 1e3, ".3f", "", 5, OfUnbroken::nothing},
        &Row::first_break_x);
  visit(ResultInfo{"first_break_y", "m", "position of the first break along the width", place, quantiles,
                   nowhere, "first break at y", "mm", 1e3, ".3f", "", 5, OfUnbroken::nothing},
        &Row::first_break_y);
  visit(ResultInfo{"first_break_z", "m", "position of the first break along the length", place, quantiles,
                   nowhere, "first break at z", "mm", 1e3, ".3f", "", 5, OfUnbroken::nothing},
        &Row::first_break_z);
  visit(ResultInfo{"first_break_load", "N", "load of the testing machine at the first break", body, quantiles,
                   in_sensitivities, "first break load", "N", 1, ".3f", "", 4, OfUnbroken::bound},
        &Row::first_break_load);
  visit(
      ResultInfo{
          "onset_time", "s",
          "load time at the start of the last dynamic phase; NaN if no quasi-static loading preceded it",
          body, quantiles, nowhere, "onset time", "s", 1, ".6f", "", 4, OfUnbroken::nothing, false, true},
      &Row::onset_time);
  visit(ResultInfo{"onset_force", "N", "load of the testing machine at that time", body, quantiles,
                   in_watch | in_sweep, "onset force", "N", 1, ".3f", "", 4, OfUnbroken::bound, false, true},
        &Row::onset_force);
  visit(ResultInfo{"peak_load", "N", "largest load of the testing machine up to separation", body, quantiles,
                   in_watch | in_sweep | in_sensitivities, "peak load", "N", 1, ".3f", "", 4,
                   OfUnbroken::bound, false, true},
        &Row::peak_load);
  visit(
      ResultInfo{
          "displacement_at_peak", "m",
          "displacement of the machine along its drive when that load first comes within 0.1 % of its peak: "
          "the prescribed one, or the mean over the loaded area",
          body, quantiles, in_sensitivities, "displacement at peak", "mm", 1e3, ".5f", "", 4,
          OfUnbroken::nothing, false, true},
      &Row::displacement_at_peak);
  visit(
      ResultInfo{"work_of_fracture", "J",
                 "external work up to separation: the area below the load-displacement curve, and the energy "
                 "of stress and velocity at the start",
                 body, quantiles, in_sensitivities, "work of fracture", "mJ", 1e3, ".3f", "", 4,
                 OfUnbroken::nothing, false, true},
      &Row::work_of_fracture);
  visit(ResultInfo{"dynamic_phases", "", "number of dynamic phases", body, none, nowhere, "dynamic phases",
                   "", 1, "d"},
        &Row::dynamic_phases);
  visit(ResultInfo{"crack_area_before_onset", "m^2", "crack area before the last dynamic phase", body,
                   quantiles, nowhere, "rough crack area before onset", "mm^2", 1e6, ".2f"},
        &Row::crack_area_before_onset);
  visit(
      ResultInfo{
          "outcome", "",
          "how the sample ended (arrested: the load grows no further; in one piece: when the duration was "
          "over; undecided: still breaking after three durations)",
          body, shares, in_watch, "outcome", "", 1, "d",
          "0 unbroken, 1 arrested, 2 separated, 3 in one piece, 4 undecided"},
      &Row::outcome);
  visit(
      ResultInfo{"held", "",
                 "1 if the body arrested at its largest load, that at the end of the loading: peak load and "
                 "onset lie above it",
                 body, none, nowhere, "held", "", 1, "d", "", 8},
      &Row::held);
  visit(ResultInfo{"pattern", "", "crack pattern", path, none, in_watch | in_sweep | in_sensitivities,
                   "pattern", "", 1, "d", pattern_categories},
        &Row::pattern);
  visit(
      ResultInfo{
          "leading_notch", "",
          "crack start whose crack crosses the largest share of its ligament; -1 where none has started",
          path, none, in_sensitivities, "leading start", "", 1, "d", "", 4, OfUnbroken::value, true},
      &Row::leading_start);
  visit(ResultInfo{"hole", "", "crack start of the first hole that the leading crack runs into; -1 for none",
                   hole, none, nowhere, "hole", "", 1, "d", "", 6, OfUnbroken::value, true},
        &Row::hole);
  visit(ResultInfo{"hole_passage", "", "whether that crack ends in the hole or goes on from it", hole, none,
                   nowhere, "at the hole", "", 1, "d", passage_categories, 6},
        &Row::hole_passage);
  visit(ResultInfo{"overlap", "1",
                   "share of the two cracks' paths in which one lies over the other turned by 180 degrees",
                   path, none, nowhere, "overlap", "%", 100, ".0f"},
        &Row::overlap);
  visit(ResultInfo{"bifurcations", "",
                   "number of branching points in space, in plates seen in windows through the thickness",
                   body, counts, nowhere, "branching in space", "", 1, "d"},
        &Row::branching_points);
  visit(ResultInfo{"long_bifurcations", "", "number of those with branches of [output] branch_length or more",
                   body, counts, in_sweep, "long branches in space", "", 1, "d", "", 7},
        &Row::long_branching_points);
  visit(ResultInfo{"bifurcations_projected", "",
                   "number of branching points of the crack projected on the plane of the plate", path,
                   counts, in_watch | in_sweep | in_sensitivities, "branching projected", "", 1, "d"},
        &Row::branching_points_projected);
  visit(ResultInfo{"kinks", "",
                   "number of kinks of all crack lines: turns of 26 degrees or more within 0.08 ligaments",
                   path, counts, nowhere, "kinks", "", 1, "d"},
        &Row::kinks);
  visit(ResultInfo{"breaks", "", "number of broken tetrahedra", body, none, nowhere, "breaks", "", 1, "d"},
        &Row::breaks);
  visit(ResultInfo{"crack_area", "m^2",
                   "area of all opened dual facets: of a rough surface, about twice its projection", body,
                   quantiles, in_watch | in_sweep | in_sensitivities, "rough crack area", "mm^2", 1e6, ".1f"},
        &Row::crack_area);
  visit(ResultInfo{"crack_speed_max", "m/s",
                   "largest speed along the crack in the last dynamic phase, over a tenth of the ligament or "
                   "more; NaN if it advances by less",
                   path, quantiles, in_watch | in_sweep | in_sensitivities, "crack speed", "m/s", 1, ".1f"},
        &Row::crack_speed_max);
  visit(ResultInfo{"crack_speed_ratio", "1",
                   "largest ratio of that speed to the Rayleigh speed of what breaks there", path, quantiles,
                   nowhere, "crack speed / Rayleigh speed", "", 1, ".3f"},
        &Row::crack_speed_ratio);
  visit(ResultInfo{"traced_area", "m^2", "length of the crack lines times the thickness", path, quantiles,
                   nowhere, "traced area", "mm^2", 1e6, ".1f"},
        &Row::traced_area);
  visit(ResultInfo{"effective_toughness", "J/m^2",
                   "released energy over the traced area, also that of breaks beside the crack", path,
                   quantiles, in_sensitivities, "energy per traced area", "J/m^2", 1, ".3f"},
        &Row::effective_toughness);
  visit(ResultInfo{"energy_error", "1", "largest imbalance of the energy account relative to the work done",
                   computation, quantiles, in_watch, "energy error", "", 1, ".1e"},
        &Row::energy_error);
  visit(
      ResultInfo{"equilibrium_residual", "1",
                 "largest residual of the static solves over that of their loads; NaN without static solves",
                 computation, quantiles, nowhere, "equilibrium residual", "", 1, ".1e"},
      &Row::equilibrium_residual);
}

/// Calls visit(info, member) for every result with starts x sections values per sample: /summary/<name> of a
/// sample file, /crack_path/<name> of the ensemble's.
template <class Visit>
void for_each_position_result(Visit&& visit) {
  using Row = SampleSummary;
  using enum About;
  using enum Reduction;
  visit(
      ResultInfo{
          "position", "m",
          "coordinate along the section, z for y = const and y for z = const: through-thickness mean of "
          "the main branch of the crack from this start; NaN where it did not arrive",
          path, quantiles, nowhere, "position", "mm", 1e3, ".3f"},
      &Row::position);
  visit(ResultInfo{"z_spread", "m", "standard deviation of the position through the thickness", path, none,
                   nowhere, "spread of the position", "mm", 1e3, ".3f"},
        &Row::z_spread);
  visit(
      ResultInfo{"arrival_time", "s",
                 "through-thickness mean of when the crack opened there, since the start of the last dynamic "
                 "phase, negative where it had run before; NaN where it did not arrive",
                 path, quantiles, nowhere, "arrival", "us", 1e6, ".2f"},
      &Row::arrival_time);
  visit(ResultInfo{"branches", "", "number of separate crossings there, of all branches", path, none, nowhere,
                   "crossings", "", 1, "d"},
        &Row::branches);
}

/// Calls visit(info, member of cracks::StartTrace) for every result with planes x cracks::n_trace_rows values
/// per sample: /summary/traces/<name> of a sample file with [[sections.plane]], /plane_traces/<name> of the
/// ensemble's.
template <class Visit>
void for_each_trace_result(Visit&& visit) {
  using Trace = cracks::StartTrace;
  using enum About;
  using enum Reduction;
  visit(ResultInfo{"length", "m", "length of all traces in the plane; 0 where no crack came", body, none,
                   nowhere, "length", "mm", 1e3, ".3f", "", 7},
        &Trace::length);
  visit(ResultInfo{"along", "m", "their mean place: distance from the plane's point along its first axis",
                   body, none, nowhere, "along", "mm", 1e3, ".3f", "", 7},
        &Trace::along);
  visit(ResultInfo{"across", "m", "likewise along its second axis", body, none, nowhere, "across", "mm", 1e3,
                   ".3f", "", 7},
        &Trace::across);
  visit(ResultInfo{"time", "s",
                   "when the first crack came to the plane, since the start of the last dynamic phase", body,
                   none, nowhere, "time", "us", 1e6, ".2f", "", 7},
        &Trace::time);
}

/// Calls visit(info, member of FragmentSummary) for every number of a sample's fragments:
/// /summary/fragments/<name> of a sample file, /fragments/<name> of the ensemble's.
template <class Visit>
void for_each_fragment_result(Visit&& visit) {
  using Row = FragmentSummary;
  using enum About;
  using enum Reduction;
  const auto see = [&](const char* name, const char* units, const char* meaning, const char* label,
                       const char* shown_units, double factor, const char* format, auto member) {
    visit(ResultInfo{name, units, meaning, body, none, nowhere, label, shown_units, factor, format, "", 7},
          member);
  };
  see("number", "", "number of fragments: pieces of two nodes or more", "fragments", "", 1, ".1f",
      &Row::number);
  see("largest_mass", "kg", "mass of the largest fragment", "largest", "g", 1e3, ".4g", &Row::largest_mass);
  see("second_mass", "kg", "mass of the second largest fragment; 0 if there is none", "second", "g", 1e3,
      ".4g", &Row::second_mass);
  see("mean_mass", "kg", "mean mass of the fragments", "mean", "g", 1e3, ".4g", &Row::mean_mass);
  see("median_mass", "kg", "median of their masses", "median", "g", 1e3, ".4g", &Row::median_mass);
  see("dust_mass", "kg", "mass of dust: of single nodes that nothing holds", "dust", "g", 1e3, ".4g",
      &Row::dust_mass);
  see("fastest", "m/s", "largest speed of the mean motion of a fragment", "fastest", "m/s", 1, ".4g",
      &Row::fastest);
  see("kinetic_energy", "J", "kinetic energy of the mean motions of all fragments", "kinetic energy", "mJ",
      1e3, ".4g", &Row::kinetic_energy);
  see("frozen", "", "number of fragments and single nodes that were frozen: numbers out of range", "frozen",
      "", 1, ".1f", &Row::frozen);
  see("frozen_mass", "kg", "their mass", "frozen mass", "g", 1e3, ".4g", &Row::frozen_mass);
  see("frozen_energy", "J", "kinetic energy taken from them", "frozen energy", "mJ", 1e3, ".4g",
      &Row::frozen_energy);
  // The last one.
  see("body_mass", "kg", "mass of the whole body", "body", "g", 1e3, ".4g", &Row::body_mass);
}

/// The area of the cracks in each of the crack_parts: /summary/crack_area_in of a sample file,
/// /samples/crack_area_in of the ensemble's, with the parts as an attribute.
inline constexpr ResultInfo crack_area_in_info{
    "crack_area_in",
    "m^2",
    "crack_area in each material, except at its interfaces, and at each [[interface]]; of several materials",
    About::body,
    Reduction::none,
    nowhere,
    "crack area",
    "mm^2",
    1e6,
    ".1f",
    "",
    6};

inline constexpr const char* heavier_meaning =
    "number of fragments of at least each share of the body's mass";

/// Visits every field, for a Packer.
void for_each_field(std::derived_from<FragmentSummary> auto& row, const auto& visit) {
  for_each_fragment_result([&](const ResultInfo&, auto member) { visit(row.*member); });
  visit(row.heavier);
}

/// Visits every field of a row, for a Packer: messages between ranks of the same architecture.
void for_each_field(std::derived_from<SampleSummary> auto& row, const auto& visit) {
  visit(row.status, row.error, row.note, row.inputs);
  for_each_result([&](const ResultInfo&, auto member) { visit(row.*member); });
  for_each_position_result([&](const ResultInfo&, auto member) { visit(row.*member); });
  visit(row.crack_area_in, row.traces, row.fragments, row.wall_time);
}

/// A result as a number; NaN for a negative integer, which means that there is none.
template <class Number>
double number_or_nan(Number value) {
  if constexpr (std::integral<Number>)
    return value < 0 ? not_a_number : static_cast<double>(value);
  else
    return value;
}

/// A number, or a lower bound of it.
struct Observation {
  double value = not_a_number;  ///< NaN if there is none
  bool is_bound = false;        ///< the number lies above it
};

/// True if the sample ended before the result was decided.
inline bool is_open(const ResultInfo& info, const SampleSummary& row) {
  return info.of_unbroken != OfUnbroken::value && (is_unbroken(row) || (info.tells_the_end && is_held(row)));
}

/// True if the result lies above the sample's peak load.
inline bool is_bound(const ResultInfo& info, const SampleSummary& row) {
  return info.of_unbroken == OfUnbroken::bound && is_open(info, row);
}

/// The observation of a result by a sample: none unless it is done.
template <class Member>
Observation observed(const ResultInfo& info, Member member, const SampleSummary& row) {
  if (row.status != SampleStatus::done) return {};
  if (!is_open(info, row)) return {number_or_nan(row.*member)};
  return is_bound(info, row) ? Observation{row.peak_load, true} : Observation{};
}

/// The value, NaN if there is at most a bound.
template <class Member>
double known(const ResultInfo& info, Member member, const SampleSummary& row) {
  const Observation one = observed(info, member, row);
  return one.is_bound ? not_a_number : one.value;
}

using crackle::shown;
/// A number in the syntax of fmt, with "> " before a bound; "-" for NaN.
std::string shown(const Observation& one, const std::string& format, double factor = 1);

/// The format with as many decimals as the numbers that it shows deserve: three digits of their scatter or,
/// without scatter, five of their size; never more decimals than it has.
/// @param values in SI; NaN counts as none
std::string fitting_format(const std::string& format, std::span<const Observation> values, double factor = 1);

/// The word of a category: category_name("0 none, 1 one crack", 1) is "one crack"; the number itself if it
/// has no word.
std::string category_name(const char* categories, std::int64_t value);

/// Number of categories.
int n_categories(const char* categories);

/// All results as the Markdown table of jobs/results.md.
std::string result_table();

}  // namespace crackle::analysis
