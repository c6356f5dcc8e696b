// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibration_steps.h"

#include "crackle/analysis/statistics.h"
#include "crackle/common/index.h"
#include "crackle/experiment/matching.h"
#include "crackle/experiment/rank_test.h"

#include <fmt/format.h>
#include <boost/math/distributions/fisher_f.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace crackle::experiment {

namespace {

constexpr std::array coverage_levels{0.5, 0.9};
constexpr double interval_confidence = 0.95;
/// Draws that are left out in turn.
constexpr std::size_t most_left_out = 200;
/// Less is too few points for an interval.
constexpr double least_effective_size = 1000;

/// The results of a draw as an experiment.
ObservedComponents draw_as_experiment(const CalibrationData& data, Eigen::Index row) {
  ObservedComponents observed{
      .mean = {}, .share = {}, .error = data.observed.error, .blocks = data.observed.blocks, .contrasts = {}};
  set_observed(data.as_read.row(row), observed);
  return observed;
}

/// Share of a posterior below the true value of each input, and the least distance.
struct LeftOut {
  std::vector<double> below;
  double squared_distance;
};

LeftOut leave_out(const CalibrationData& data, const Emulator& emulator, std::size_t draw,
                  const RandomStream& stream) {
  std::vector<Eigen::Index> columns(index(emulator.n_components()));
  for (std::size_t c = 0; c < columns.size(); ++c) columns[c] = static_cast<Eigen::Index>(c);
  const Emulator others = emulator.refitted(data.values.without(draw), columns);
  const auto row = std::ranges::lower_bound(data.values.draw, draw) - data.values.draw.begin();
  const ObservedComponents observed = draw_as_experiment(data, row);
  const PosteriorPoints points =
      posterior_of(SyntheticLikelihood(others, observed, {}), small_effort, stream);
  LeftOut found{{}, points.least_squared_distance};
  const InputTable& table = emulator.basis().table;
  for (std::size_t k = 0; k < table.n_inputs(); ++k) {
    const auto values = input_values(table, k, points);
    double below = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (values[i] < data.draws[draw][k]) below += points.weight[static_cast<Eigen::Index>(i)];
    found.below.push_back(below);
  }
  return found;
}

std::vector<Coverage> coverage_of(const CalibrationData& data, const std::vector<LeftOut>& draws) {
  std::vector<Coverage> all;
  for (std::size_t k = 0; k < data.random.size(); ++k) {
    for (const double level : coverage_levels) {
      Coverage one{.key = data.random[k].key, .level = level, .n_draws = static_cast<int>(draws.size())};
      one.n_covered = static_cast<int>(std::ranges::count_if(
          draws, [&](const LeftOut& draw) { return std::abs(draw.below[k] - 0.5) <= level / 2; }));
      const auto [lower, upper] = analysis::share_interval(one.n_covered, one.n_draws, interval_confidence);
      one.lower = lower;
      one.upper = upper;
      all.push_back(std::move(one));
    }
  }
  return all;
}

/// Adds what the scatter between samples of the same draw tells of a component.
void add_lack_of_fit(const EmulatedValues& values, const Eigen::MatrixXd& residual, const Emulator& emulator,
                     Eigen::Index c, EmulatedComponent& component) {
  double within = 0;
  const std::size_t n = values.draw.size();
  for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
    while (end < n && values.draw[end] == values.draw[begin]) ++end;
    const auto own =
        values.value.col(c).segment(static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(end - begin));
    within += (own.array() - own.mean()).square().sum();
  }
  const auto n_draws = static_cast<double>(values.n_draws());
  const double degrees_within = static_cast<double>(n) - n_draws;
  const double degrees = n_draws - static_cast<double>(emulator.n_terms(c));
  if (degrees_within < 1 || degrees < 1 || within <= 0) return;
  const double mean_within = within / degrees_within;
  const double between = std::max(0.0, residual.col(c).squaredNorm() - within) / degrees;
  component.mesh = mean_within / emulator.variance()[c];
  component.lack_of_fit_p_value =
      cdf(complement(boost::math::fisher_f(degrees, degrees_within), between / mean_within));
}

std::vector<EmulatedComponent> emulated_components(const CalibrationData& data, const Emulator& emulator) {
  std::vector<EmulatedComponent> components;
  const Eigen::MatrixXd residual = emulator.residuals(data.values);
  for (const QuantityBlock& block : data.observed.blocks) {
    for (Eigen::Index k = 0; k < block.count; ++k) {
      const Eigen::Index c = block.first + k;
      EmulatedComponent one{.quantity = block.count == 1 ? block.name : fmt::format("{}[{}]", block.name, k),
                            .degree = emulator.degree()[index(c)],
                            .predicted = emulator.predicted()[index(c)]};
      add_lack_of_fit(data.values, residual, emulator, c, one);
      components.push_back(std::move(one));
    }
  }
  return components;
}

}  // namespace

CalibrationChecks calibration_checks(const CalibrationData& data, const Emulator& emulator,
                                     const RandomStream& stream) {
  CalibrationChecks checks;
  const std::size_t n = data.draws.size(), n_left_out = std::min(n, most_left_out);
  std::vector<LeftOut> draws;
  for (std::size_t i = 0; i < n_left_out; ++i)
    draws.push_back(leave_out(data, emulator, i * n / n_left_out, stream.substream(i)));
  checks.coverage = coverage_of(data, draws);
  // Without the terms that make up for a wrong model, and with as few points as for the draws.
  const double own = posterior_of(SyntheticLikelihood(emulator, data.observed, {}), small_effort,
                                  stream.substream(n_left_out))
                         .least_squared_distance;
  const auto n_as_far =
      std::ranges::count_if(draws, [&](const LeftOut& draw) { return draw.squared_distance >= own; });
  checks.distance = std::sqrt(own);
  checks.n_components = index(emulator.n_components());
  checks.least_p_value = least_p_value(n_left_out);
  checks.distance_p_value = static_cast<double>(n_as_far + 1) * checks.least_p_value;
  if (data.path) checks.shape_p_value = data.path->shape_p_value;
  checks.components = emulated_components(data, emulator);
  return checks;
}

std::vector<std::string> check_warnings(const Calibration& calibration) {
  const CalibrationChecks& checks = calibration.checks;
  std::vector<std::string> warnings;
  // One of several shares is easily too small by chance.
  const double confidence =
      analysis::confidence_of_look(interval_confidence, static_cast<int>(checks.coverage.size()));
  for (const Coverage& each : checks.coverage)
    if (analysis::share_interval(each.n_covered, each.n_draws, confidence).upper < each.level)
      warnings.push_back(fmt::format(
          "{:.0f} % intervals of {} cover it in {} of {} left-out draws only: the posterior is too narrow",
          100 * each.level, each.key, each.n_covered, each.n_draws));
  if (checks.effective_size < least_effective_size)
    warnings.push_back(
        fmt::format("the posterior stands on {:.0f} effective points only; its intervals are uncertain",
                    checks.effective_size));
  if (checks.distance_p_value <= match_level)
    warnings.push_back(fmt::format(
        "the observations lie farther from the model than those of left-out draws do (p = {:.2g}): no value "
        "of the inputs explains them{}",
        checks.distance_p_value,
        calibration.options.has_discrepancy ? "" : "; --discrepancy allows for a wrong model"));
  if (checks.shape_p_value <= match_level)
    warnings.push_back(
        fmt::format("the paths have a shape that no sample's has (p = {:.2g})", checks.shape_p_value));
  for (const EmulatedComponent& each : checks.components)
    if (each.lack_of_fit_p_value <= match_level / static_cast<double>(checks.components.size()))
      warnings.push_back(fmt::format("the emulator does not follow {} (p = {:.2g}); more draws would help",
                                     each.quantity, each.lack_of_fit_p_value));
  if (std::ranges::all_of(checks.components, [](const auto& each) { return each.degree == 0; }))
    warnings.emplace_back("nothing observed depends on the inputs visibly: the posterior is the prior");
  return warnings;
}

}  // namespace crackle::experiment
