// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/experiment/matching.h"

#include <nlohmann/json.hpp>

#include <utility>

namespace crackle::experiment {

namespace {

using Json = nlohmann::ordered_json;  // writes numbers with full precision, and NaN as null

Json json_of(const analysis::BoundedMean& difference) {
  return {{"value", difference.value}, {"lower", difference.lower}, {"upper", difference.upper}};
}

Json json_of(const std::vector<Neighbour>& nearest) {
  Json list = Json::array();
  for (const auto& [sample, distance] : nearest) list.push_back({{"sample", sample}, {"distance", distance}});
  return list;
}

Json json_of(const MatchBy& by) {
  return {{"p_value", by.p_value},
          {"least_p_value", least_p_value(by.n_samples)},
          {"n_samples", by.n_samples},
          {"left_out", by.left_out},
          {"unit", by.unit},
          {"mean_distance", by.mean_distance},
          {"usual_distance", by.usual_distance},
          {"offset", by.offset},
          {"standard_deviation", by.deviation},
          {"nearest", json_of(by.nearest)}};
}

Json json_of(const PathMatch& path) {
  Json stations{{"place", path.frame.place},
                {"normal", path.frame.normal},
                {"offset", path.offset},
                {"band_lower", path.band.lower},
                {"band_upper", path.band.upper},
                {"band_level", path.band.level},
                {"band_p_value", path.band.p_value},
                {"departures", Json::array()},
                {"samples", path.samples},
                {"turned", path.turned},
                {"sample_offsets", Json::array()}};
  for (std::size_t i = 0; i < path.of_samples.n_rows(); ++i) {
    const auto row = path.of_samples.row(i);
    stations["sample_offsets"].push_back(std::vector(row.begin(), row.end()));
  }
  for (const Departure& part : path.departures)
    stations["departures"].push_back({{"from", part.from}, {"to", part.to}, {"beyond", part.beyond}});
  return stations;
}

Json json_of(const std::optional<double>& value) {
  return value ? Json(*value) : Json();
}

Json json_of(const Experiment& experiment) {
  Json one{{"lines", experiment.lines},
           {"onset_load", json_of(experiment.onset_load)},
           {"peak_load", json_of(experiment.peak_load)},
           {"load_error", experiment.load_error},
           {"pictures", Json::array()}};
  for (const Picture& picture : experiment.pictures)
    one["pictures"].push_back({{"file", picture.file.string()},
                               {"time", picture.time},
                               {"corner", picture.corner},
                               {"right", picture.right},
                               {"down", picture.down},
                               {"light_field", !picture.has_dark_field},
                               {"reversed", picture.is_reversed}});
  return one;
}

Json json_of(const ExperimentMatch& experiment) {
  Json one{{"name", experiment.name}, {"p_value", experiment.p_value}};
  const bool has_any = !experiment.by.empty();
  one["least_p_value"] = has_any ? Json(least_p_value(experiment.by.back().n_samples)) : Json();
  one["samples_needed"] = samples_needed(match_level);
  one["by"] = Json::object();
  for (const MatchBy& by : experiment.by) one["by"][by.name] = json_of(by);
  one["nearest"] = has_any ? json_of(experiment.by.back().nearest) : Json::array();
  one["path"] = experiment.path ? json_of(*experiment.path) : Json();
  one["note"] = experiment.note;
  return one;
}

Json json_of(const SetMatchBy& by) {
  const bool has_moments = by.name != "jointly";
  Json one{{"p_value", by.test.p_value()},
           {"n_experiments", by.n_experiments},
           {"n_samples", by.n_samples},
           {"unit", by.unit},
           {"energy_distance", by.test.energy},
           {"energy_p_value", by.test.energy_p_value},
           {"depth_p_value", by.test.depth_p_value},
           {"n_permutations", by.test.n_permutations},
           {"all_permutations", by.test.are_all}};
  if (!has_moments) return one;
  one["power"] = {{"shift_of_one_deviation", by.power.of_shift},
                  {"twice_the_scatter", by.power.of_scatter},
                  {"n_trials", by.power.n_trials}};
  one["shift"] = json_of(by.scatter.shift);
  one["shift_axis"] = by.axis;
  one["scatter_ratio"] = json_of(by.scatter.ratio);
  one["degrees_of_freedom"] = by.scatter.degrees;
  one["n_complete_samples"] = by.scatter.n_samples;
  one["advice"] = by.advice;
  return one;
}

Json json_of(const SetMatch& set) {
  Json one{{"p_value", set.p_value}, {"n_experiments", set.n_experiments}, {"by", Json::object()}};
  for (const SetMatchBy& by : set.by) one["by"][by.name] = json_of(by);
  return one;
}

}  // namespace

std::string to_json(const Match& match, std::span<const Experiment> experiments,
                    const ObservedSamples& samples) {
  Json document{{"experiments", Json::array()}};
  for (const ExperimentMatch& experiment : match.experiments)
    document["experiments"].push_back(json_of(experiment));
  for (std::size_t i = 0; i < experiments.size(); ++i)
    document["experiments"][i]["observed"] = json_of(experiments[i]);
  document["set"] = match.set ? json_of(*match.set) : Json();
  document["warnings"] = match.warnings;
  document["samples"] = {{"planned", match.n_planned}, {"used", match.n_used},
                         {"failed", match.failed},     {"undecided", match.undecided},
                         {"missing", match.missing},   {"loads", Json::array()}};
  for (const ObservedSample& sample : samples.samples)
    document["samples"]["loads"].push_back({{"sample", sample.number},
                                            {"onset_load", load_of(sample.summary, Quantity::onset_load)},
                                            {"peak_load", load_of(sample.summary, Quantity::peak_load)}});
  // Names need not be valid UTF-8.
  return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace crackle::experiment
