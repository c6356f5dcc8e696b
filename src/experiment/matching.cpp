// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/experiment/matching.h"

#include "crackle/analysis/running_statistics.h"
#include "crackle/analysis/statistics.h"
#include "crackle/common/checksum.h"
#include "crackle/common/index.h"
#include "crackle/common/quantity_text.h"
#include "crackle/input/reader.h"
#include "text_parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <tuple>
#include <utility>

namespace crackle::experiment {

namespace {

constexpr const char* jointly_name = "jointly";

/// The rows of some observables that all of them have.
struct CommonRows {
  std::vector<std::size_t> experiments, samples;  ///< as in Observable
};

std::vector<std::size_t> in_both(const std::vector<std::size_t>& one, const std::vector<std::size_t>& other) {
  std::vector<std::size_t> both;
  std::ranges::set_intersection(one, other, std::back_inserter(both));
  return both;
}

CommonRows common_rows(std::span<const Observable> observables) {
  CommonRows common{observables.front().experiments, observables.front().samples};
  for (const Observable& each : observables)
    common = {in_both(common.experiments, each.experiments), in_both(common.samples, each.samples)};
  return common;
}

void add_rows(const ValueTable& from, const std::vector<std::size_t>& numbers,
              const std::vector<std::size_t>& wanted, ValueTable& to) {
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (std::ranges::binary_search(wanted, numbers[i])) to.add(from.row(i));
}

/// The experiments, then the samples with errors.
ValueTable table_of(const Observable& observable, const CommonRows& rows) {
  ValueTable table{observable.of_experiments.n_columns, {}};
  add_rows(observable.of_experiments, observable.experiments, rows.experiments, table);
  add_rows(observable.with_error, observable.samples, rows.samples, table);
  return table;
}

Distances distances_by(std::span<const Observable> observables, const CommonRows& rows) {
  std::vector<Distances> distances;
  for (const Observable& each : observables) distances.push_back(distances_of(table_of(each, rows)));
  return distances.size() == 1 ? distances.front() : joint_distances(distances);
}

/// The mean over the columns of row 0 less the mean of the others, and their standard deviation. Columns that
/// row 0 does not reach do not count, nor do rows that do not reach the others.
std::pair<double, double> offset_and_deviation(const ValueTable& table) {
  const auto mean_where_row_0_is = [&](std::size_t i) {
    double sum = 0, n = 0;
    for (std::size_t c = 0; c < table.n_columns; ++c) {
      if (std::isnan(table.row(0)[c])) continue;
      sum += table.row(i)[c];
      n += 1;
    }
    return n > 0 ? sum / n : not_a_number;
  };
  analysis::Moments others;
  for (std::size_t i = 1; i < table.n_rows(); ++i)
    if (const double mean = mean_where_row_0_is(i); !std::isnan(mean)) others.add(mean);
  return {mean_where_row_0_is(0) - others.mean(), others.standard_deviation()};
}

/// Loads that are one quantity count once.
std::vector<Observable> distinct(std::span<const Observable> observables) {
  std::vector<Observable> found;
  for (const Observable& each : observables) {
    const bool is_known = std::ranges::any_of(found, [&](const Observable& other) {
      return other.samples == each.samples && other.experiments == each.experiments &&
             is_same_load(other, each);
    });
    if (!is_known) found.push_back(each);
  }
  return found;
}

MatchBy match_by(std::span<const Observable> observables, const ObservedSamples& samples) {
  const CommonRows rows = common_rows(observables);
  MatchBy by;
  by.name = observables.size() == 1 ? name_of(observables.front().quantity) : jointly_name;
  by.unit = observables.size() == 1 ? observables.front().unit : "1";
  by.n_samples = rows.samples.size();
  for (std::size_t i = 0; i < samples.samples.size(); ++i)
    if (!std::ranges::binary_search(rows.samples, i)) by.left_out.push_back(samples.samples[i].number);
  if (by.n_samples == 0) return by;
  const Distances distances = distances_by(observables, rows);
  by.p_value = rank_p_value(distances);
  for (std::size_t k = 0; k < rows.samples.size(); ++k)
    by.nearest.push_back({samples.samples[rows.samples[k]].number, distances(0, k + 1)});
  std::ranges::stable_sort(by.nearest, {}, &Neighbour::distance);
  by.nearest.resize(std::min(n_nearest, by.nearest.size()));
  std::vector<double> means = distances.means();
  by.mean_distance = means.front();
  means.erase(means.begin());
  by.usual_distance = analysis::quantile(std::move(means), 0.5);
  if (observables.size() == 1 && observables.front().quantity != Quantity::tip_times)
    std::tie(by.offset, by.deviation) = offset_and_deviation(table_of(observables.front(), rows));
  return by;
}

/// Where row 0 leaves the band, one entry for each connected part.
std::vector<Departure> departures(const PathFrame& frame, const Envelope& band,
                                  const std::vector<double>& offset) {
  std::vector<Departure> parts;
  bool goes_on = false;
  for (std::size_t k = 0; k < offset.size(); ++k) {
    if (!band.is_outside[k]) {
      goes_on = false;
      continue;
    }
    if (!goes_on) parts.push_back({frame.place[k], frame.place[k]});
    goes_on = true;
    Departure& part = parts.back();
    part.to = frame.place[k];
    const double beyond = offset[k] > band.upper[k] ? offset[k] - band.upper[k] : offset[k] - band.lower[k];
    if (std::isnan(part.beyond) || std::abs(beyond) > std::abs(part.beyond)) part.beyond = beyond;
  }
  return parts;
}

std::optional<PathMatch> match_path(const Observable& observable, const ObservedSamples& samples) {
  if (!observable.frame || observable.samples.empty()) return std::nullopt;
  PathMatch path{.frame = *observable.frame, .of_samples = observable.of_samples};
  for (const std::size_t i : observable.samples) path.samples.push_back(samples.samples[i].number);
  for (const std::size_t i : observable.turned) path.turned.push_back(samples.samples[i].number);
  path.band = envelope(table_of(observable, common_rows({&observable, 1})), 1 - match_level);
  const auto row = observable.of_experiments.row(0);
  path.offset.assign(row.begin(), row.end());
  path.departures = departures(path.frame, path.band, path.offset);
  return path;
}

SetMatchBy match_set_by(std::span<const Observable> observables) {
  const CommonRows rows = common_rows(observables);
  SetMatchBy by;
  by.n_experiments = rows.experiments.size();
  by.n_samples = rows.samples.size();
  if (by.n_experiments < 2 || by.n_samples < 2) return by;
  by.test = group_test(distances_by(observables, rows), by.n_experiments);
  by.name = observables.size() == 1 ? name_of(observables.front().quantity) : jointly_name;
  by.unit = observables.size() == 1 ? observables.front().unit : "1";
  if (observables.size() > 1) return by;
  const Observable& only = observables.front();
  by.power = power(only.with_error, by.n_experiments, n_power_trials);
  by.scatter = scatter(only.of_experiments, only.of_samples, only.error, 1 - match_level);
  if (only.frame) by.axis = only.frame->is_along_y ? "y" : "z";
  by.advice = advice(by);
  return by;
}

std::optional<SetMatch> match_set(std::span<const Experiment> experiments, const ObservedSamples& samples,
                                  const geometry::Body& body) {
  if (experiments.size() < 2) return std::nullopt;
  SetMatch found;
  std::vector<Observable> used;
  for (Observable& each : observe(experiments, samples, body, 0)) {
    SetMatchBy by = match_set_by({&each, 1});
    if (by.name.empty()) continue;
    found.by.push_back(std::move(by));
    used.push_back(std::move(each));
  }
  if (used.empty()) return std::nullopt;
  if (const auto all = distinct(used); all.size() > 1)
    if (SetMatchBy by = match_set_by(all); !by.name.empty()) found.by.push_back(std::move(by));
  const auto p_value = [](const SetMatchBy& by) { return by.test.p_value(); };
  const SetMatchBy& least = *std::ranges::min_element(found.by, {}, p_value);
  const bool is_joint = found.by.back().name == jointly_name;
  found.p_value = is_joint ? p_value(found.by.back())
                           : std::min(1.0, static_cast<double>(distinct(used).size()) * p_value(least));
  found.n_experiments = std::ranges::max_element(found.by, {}, &SetMatchBy::n_experiments)->n_experiments;
  return found;
}

/// Number of samples whose crack is turned onto the start of an experiment's.
std::ptrdiff_t count_turned(const ObservedSamples& samples, std::span<const Experiment> experiments,
                            const geometry::Body& body) {
  std::set<int> starts;
  for (const Experiment& experiment : experiments)
    if (needs_arms({&experiment, 1})) starts.insert(crack_start_of(body, experiment));
  return std::ranges::count_if(samples.samples, [&](const ObservedSample& sample) {
    return std::ranges::any_of(starts, [&](int start) {
      const bool has_arm =
          start >= 0 && index(start) < sample.arms.size() && !sample.arms[index(start)].empty();
      return has_arm && sample.arms[index(start)].front().is_turned;
    });
  });
}

std::vector<std::string> warnings_of(const ObservedSamples& samples, std::span<const Experiment> experiments,
                                     const geometry::Body& body, const input::Parameters& parameters) {
  std::vector<std::string> warnings;
  const std::size_t n = samples.samples.size();
  if (parameters.mesh.base == input::Base::shared && !parameters.mesh.points)
    warnings.emplace_back(
        "the samples share their base of mother points (mesh.base = \"shared\"), an experiment does not: "
        "they are more alike than bodies of their own are, and the p-values are too small, so not valid; "
        "compute "
        "the ensemble with base = \"own\"");
  if (parameters.mesh.points)
    warnings.emplace_back(
        "the samples share their base of mother points, mesh.points, an experiment does not: the p-values "
        "are too small, so not valid");
  if (parameters.ensemble.replicates > 1)
    warnings.push_back(fmt::format(
        "{} samples share each draw of the random inputs, so they are not independent, and the p-values are "
        "not exact",
        parameters.ensemble.replicates));
  if (n < samples_needed(match_level))
    warnings.push_back(
        fmt::format("{} cannot give a p-value below {:.2g}, whatever the experiment; {} are needed for {}",
                    count_text(n, "sample"), least_p_value(n), samples_needed(match_level), match_level));
  if (const auto n_turned = count_turned(samples, experiments, body); n_turned > 0)
    warnings.push_back(
        fmt::format("in {} of the samples another crack leads than that from the experiment's start; their "
                    "paths are turned by the symmetry of body and loads",
                    n_turned));
  return warnings;
}

}  // namespace

ExperimentMatch match_one(const Experiment& experiment, const ObservedSamples& samples,
                          const geometry::Body& body) {
  ExperimentMatch found{.name = experiment.name};
  const auto observables = observe({&experiment, 1}, samples, body, checksum(experiment.name));
  for (const Observable& each : observables) {
    found.by.push_back(match_by({&each, 1}, samples));
    if (each.quantity == Quantity::path) found.path = match_path(each, samples);
  }
  if (const auto jointly = distinct(observables); jointly.size() > 1)
    found.by.push_back(match_by(jointly, samples));
  if (!found.by.empty()) found.p_value = found.by.back().p_value;
  if (!experiment.lines.empty() && !found.path)
    found.note = "its path has no part in common with those of the samples";
  else if (found.by.empty())
    found.note = "nothing in it can be compared with the samples";
  return found;
}

Match match(std::span<const Experiment> experiments, const ObservedSamples& samples,
            const geometry::Body& body, const input::Parameters& parameters) {
  Match found{.set = match_set(experiments, samples, body),
              .warnings = warnings_of(samples, experiments, body, parameters),
              .n_planned = samples.n_planned,
              .n_used = samples.samples.size(),
              .failed = samples.failed,
              .undecided = samples.undecided,
              .missing = samples.missing};
  for (const Experiment& experiment : experiments)
    found.experiments.push_back(match_one(experiment, samples, body));
  return found;
}

std::string advice(const SetMatchBy& by) {
  const auto &ratio = by.scatter.ratio, &shift = by.scatter.shift;
  // Intervals of scatter and shift assume normal distributions; of few experiments they are easily too short.
  const double p = by.test.p_value();
  const bool is_confirmed = p <= match_level;
  std::string text;
  if (!std::isnan(ratio.value)) {
    const std::string times =
        fmt::format("{:#.2g} times as much ({:#.2g} to {:#.2g})", ratio.value, ratio.lower, ratio.upper);
    if (ratio.lower <= 1 && ratio.upper >= 1)
      text = fmt::format("The experiments scatter {}: no evidence that the disturbance is wrong.", times);
    else if (!is_confirmed)
      text = fmt::format("The experiments scatter {}, but with p = {:.2g} that may be chance.", times, p);
    else
      text = fmt::format(
          "The experiments scatter {}: {}.", times,
          ratio.lower > 1 ? "more disturbance or a varying material" : "less disturbance or a finer mesh");
  }
  if (std::isnan(shift.lower)) return text;
  const std::string along = by.axis.empty() ? "" : " in " + by.axis;
  const double largest = largest_magnitude({shift.value, shift.lower, shift.upper});
  const auto text_of = [&](double value) { return quantity_text(value, by.unit, 3, largest); };
  const std::string size =
      fmt::format("{}{} ({} to {})", text_of(shift.value), along, text_of(shift.lower), text_of(shift.upper));
  const bool is_sure = is_confirmed && (shift.lower > 0 || shift.upper < 0);
  return text + (text.empty() ? "" : " ") +
         (is_sure
              ? fmt::format("A shift of {}: no disturbance will cure that; look at material, supports and "
                            "dimensions.",
                            size)
              : fmt::format("Their mean is {} off, which may be chance.", size));
}

}  // namespace crackle::experiment
