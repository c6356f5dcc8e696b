// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/common/index.h"
#include "crackle/experiment/calibration.h"

#include <nlohmann/json.hpp>

#include <utility>

namespace crackle::experiment {

namespace {

using Json = nlohmann::ordered_json;  // writes numbers with full precision, and NaN as null

Json json_of(const Spread& spread) {
  return {{"mean", spread.mean},
          {"standard_deviation", spread.standard_deviation},
          {"lower", spread.lower},
          {"upper", spread.upper}};
}

Json json_of(const CalibratedInput& input) {
  return {{"key", input.random.key},
          {"unit", input.random.unit},
          {"distribution", input::distribution_names[index(input.random.distribution)]},
          {"prior", json_of(input.prior)},
          {"posterior", json_of(input.posterior)},
          {"ratio", input.ratio()}};
}

Json json_of(const CalibratedScale& scale) {
  return {{"quantity", scale.quantity},
          {"unit", scale.unit},
          {"kind", scale.is_discrepancy ? "discrepancy" : "between_specimens"},
          {"posterior", json_of(scale.posterior)}};
}

Json json_of(const Information& information) {
  Json one{{"bits", information.bits}, {"inputs", Json::array()}};
  for (const Spread& each : information.inputs) one["inputs"].push_back(json_of(each));
  return one;
}

Json json_of(const Contribution& contribution) {
  return {{"quantity", contribution.quantity},
          {"alone", json_of(contribution.alone)},
          {"without", contribution.without ? json_of(*contribution.without) : Json()}};
}

Json json_of(const Prediction& prediction) {
  return {{"name", prediction.name},
          {"unit", prediction.unit},
          {"predicted", json_of(prediction.predicted)},
          {"observed", prediction.observed},
          {"place", prediction.place}};
}

Json json_of(const PredictedPath& path) {
  Json one{{"place", Json::array()}, {"normal", Json::array()}, {"observed", Json::array()},
           {"mean", Json::array()},  {"lower", Json::array()},  {"upper", Json::array()}};
  for (std::size_t k = 0; k < path.stations.size(); ++k) {
    one["place"].push_back(path.frame.place[path.stations[k]]);
    one["normal"].push_back(path.frame.normal[path.stations[k]]);
    one["observed"].push_back(path.at[k].observed);
    one["mean"].push_back(path.at[k].predicted.mean);
    one["lower"].push_back(path.at[k].predicted.lower);
    one["upper"].push_back(path.at[k].predicted.upper);
  }
  return one;
}

Json json_of(const Coverage& coverage) {
  return {{"key", coverage.key},         {"level", coverage.level},
          {"n_draws", coverage.n_draws}, {"n_covered", coverage.n_covered},
          {"lower", coverage.lower},     {"upper", coverage.upper}};
}

Json json_of(const EmulatedComponent& component) {
  return {{"quantity", component.quantity},
          {"degree", component.degree},
          {"predicted", component.predicted},
          {"mesh", component.mesh},
          {"lack_of_fit_p_value", component.lack_of_fit_p_value}};
}

template <class List>
Json list_of(const List& all) {
  Json list = Json::array();
  for (const auto& each : all) list.push_back(json_of(each));
  return list;
}

Json json_of(const CalibrationChecks& checks) {
  return {{"coverage", list_of(checks.coverage)},
          {"effective_size", checks.effective_size},
          {"distance",
           {{"value", checks.distance},
            {"n_components", checks.n_components},
            {"p_value", checks.distance_p_value},
            {"least_p_value", checks.least_p_value}}},
          {"shape_p_value", checks.shape_p_value},
          {"emulator", list_of(checks.components)}};
}

}  // namespace

std::string to_json(const Calibration& found) {
  Json document{{"level", calibration_level},
                {"experiments", found.experiments},
                {"discrepancy", found.options.has_discrepancy},
                {"between_specimens", found.options.has_specimen_scatter},
                {"inputs", list_of(found.inputs)},
                {"correlation", found.correlation},
                {"bits", found.bits},
                {"scales", list_of(found.scales)},
                {"contributions", list_of(found.contributions)},
                {"predictions", list_of(found.predictions)},
                {"path", found.path ? json_of(*found.path) : Json()},
                {"checks", json_of(found.checks)},
                {"draws", {{"values", found.draws}, {"weights", found.weights}}},
                {"warnings", found.warnings},
                {"notes", found.notes}};
  document["samples"] = {{"planned", found.n_planned},   {"used", found.n_used},
                         {"draws", found.n_draws},       {"failed", found.failed},
                         {"undecided", found.undecided}, {"missing", found.missing},
                         {"left_out", found.left_out}};
  // Names need not be valid UTF-8.
  return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace crackle::experiment
