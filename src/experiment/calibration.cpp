// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/experiment/calibration.h"
#include "crackle/common/quantity_text.h"

#include "calibration_steps.h"
#include "crackle/common/failure.h"
#include "crackle/common/index.h"

#include <boost/math/distributions/normal.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

namespace crackle::experiment {

namespace {

/// Draws that an emulator needs, for each input and one more, as for sensitivities.
constexpr std::size_t least_draws_per_input = 4;
/// Degrees of freedom that the distribution of the observations needs.
constexpr double least_degrees = 5;
/// Posterior draws that are handed out.
constexpr std::size_t n_shown_draws = 500;

/// @param lacking degrees of freedom
void require_draws(const CalibrationData& data, double lacking) {
  const std::size_t n = data.draws.size();
  const std::size_t needed = std::max(least_draws_per_input * (data.random.size() + 1),
                                      n + static_cast<std::size_t>(std::ceil(std::max(0.0, lacking))));
  if (n >= needed) return;
  fail(
      "{} draws of the random inputs with all that is compared are too few for an emulator of {} "
      "with {}; {} or more are needed",
      n, count_text(data.values.value.cols(), "number"), count_text(data.random.size(), "input"), needed);
}

std::vector<Spread> input_spreads(const InputTable& table, const PosteriorPoints& points) {
  std::vector<Spread> spreads;
  for (std::size_t k = 0; k < table.n_inputs(); ++k)
    spreads.push_back(spread_of(input_values(table, k, points), points.weight));
  return spreads;
}

Spread prior_of(const InputTable& table, std::size_t input) {
  const double end = boost::math::quantile(boost::math::normal(), (1 + calibration_level) / 2);
  return {table.mean(input), table.standard_deviation(input), table.value(input, -end),
          table.value(input, end)};
}

/// The inputs by the components of some quantities.
Information information(const CalibrationData& data, const Emulator& emulator,
                        const std::vector<std::size_t>& blocks, const CovarianceTerms& terms,
                        const RandomStream& stream) {
  std::vector<Eigen::Index> columns;
  std::vector<QuantityBlock> own;
  for (const std::size_t k : blocks) {
    own.push_back(data.observed.blocks[k]);
    for (Eigen::Index c = 0; c < own.back().count; ++c) columns.push_back(own.back().first + c);
    own.back().first = std::ssize(columns) - own.back().count;
  }
  const Emulator of_columns = emulator.refitted(data.values, columns);
  const ObservedComponents observed = data.observed.only(columns, own);
  const SyntheticLikelihood likelihood(of_columns, observed, terms);
  const PosteriorPoints points = posterior_of(likelihood, {1000, 1000, 10}, stream);
  return {points.bits, input_spreads(emulator.basis().table, points)};
}

std::vector<Contribution> contributions(const CalibrationData& data, const Emulator& emulator,
                                        const CovarianceTerms& terms, const RandomStream& stream) {
  std::vector<Contribution> all;
  const std::size_t n = data.observed.blocks.size();
  for (std::size_t k = 0; k < n; ++k) {
    Contribution one{.quantity = data.observed.blocks[k].name};
    one.alone = information(data, emulator, {k}, terms, stream.substream(2 * k));
    std::vector<std::size_t> others(n);
    std::iota(others.begin(), others.end(), 0);
    std::erase(others, k);
    if (!others.empty())
      one.without = information(data, emulator, others, terms, stream.substream(2 * k + 1));
    all.push_back(std::move(one));
  }
  return all;
}

std::vector<std::vector<double>> correlations(const InputTable& table, const PosteriorPoints& points,
                                              const std::vector<CalibratedInput>& inputs) {
  const std::size_t n = inputs.size();
  Eigen::MatrixXd centred(std::ssize(points.point), static_cast<Eigen::Index>(n));
  for (std::size_t k = 0; k < n; ++k) {
    const auto values = input_values(table, k, points);
    centred.col(static_cast<Eigen::Index>(k)) =
        (Eigen::Map<const Eigen::ArrayXd>(values.data(), std::ssize(values)) - inputs[k].posterior.mean) /
        inputs[k].posterior.standard_deviation;
  }
  const Eigen::MatrixXd product = centred.transpose() * points.weight.asDiagonal() * centred;
  std::vector<std::vector<double>> rows(n, std::vector<double>(n, 1));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < n; ++k)
      if (i != k) rows[i][k] = product(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
  return rows;
}

void add_draws(const InputTable& table, const PosteriorPoints& points, const RandomStream& stream,
               Calibration& found) {
  const auto chosen = resampled(points.weight, n_shown_draws, stream);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (i > 0 && chosen[i] == chosen[i - 1]) {
      ++found.weights.back();
      continue;
    }
    auto& draw = found.draws.emplace_back();
    for (std::size_t k = 0; k < table.n_inputs(); ++k)
      draw.push_back(table.value(k, points.point[chosen[i]][static_cast<Eigen::Index>(k)]));
    found.weights.push_back(1);
  }
}

void add_scales(const CalibrationData& data, const SyntheticLikelihood& likelihood,
                const PosteriorPoints& points, Calibration& found) {
  const auto n_inputs = std::ssize(data.random);
  for (Eigen::Index k = n_inputs; k < likelihood.n_variables(); ++k) {
    std::vector<double> values;
    for (const auto& point : points.point) values.push_back(likelihood.scale(k - n_inputs, point[k]));
    const auto n_blocks = std::ssize(data.observed.blocks);
    const QuantityBlock& block = data.observed.blocks[index((k - n_inputs) % n_blocks)];
    found.scales.push_back({block.name, block.unit, found.options.has_discrepancy && k - n_inputs < n_blocks,
                            spread_of(values, points.weight)});
  }
}

std::vector<std::string> sample_warnings(const input::Parameters& parameters, const Calibration& found) {
  std::vector<std::string> warnings;
  if (parameters.mesh.base == input::Base::shared || parameters.mesh.points)
    warnings.emplace_back(
        "the samples share their base of mother points: the scatter between bases is not in the mesh "
        "scatter, and the posterior is too narrow; compute the ensemble with base = \"own\"");
  const std::size_t n_lacking = found.failed.size() + found.undecided.size() + found.left_out.size();
  if (n_lacking > 0)
    warnings.push_back(fmt::format(
        "{} of {} samples failed, are undecided or lack a part of the observations, and are left out: the "
        "posterior assumes that this is independent of the inputs",
        n_lacking, found.n_used + n_lacking));
  return warnings;
}

}  // namespace

std::vector<double> input_values(const InputTable& table, std::size_t input, const PosteriorPoints& points) {
  std::vector<double> values;
  for (const auto& point : points.point)
    values.push_back(table.value(input, point[static_cast<Eigen::Index>(input)]));
  return values;
}

Spread spread_of(const std::vector<double>& values, const Eigen::VectorXd& weights) {
  const Eigen::Map<const Eigen::ArrayXd> all(values.data(), std::ssize(values));
  Spread spread{.mean = (weights.array() * all).sum()};
  spread.standard_deviation = std::sqrt((weights.array() * (all - spread.mean).square()).sum());
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return values[i]; });
  const auto quantile = [&](double share) {
    double sum = 0;
    for (const std::size_t i : order) {
      sum += weights[static_cast<Eigen::Index>(i)];
      if (sum >= share) return values[i];
    }
    return values[order.back()];
  };
  spread.lower = quantile((1 - calibration_level) / 2);
  spread.upper = quantile((1 + calibration_level) / 2);
  return spread;
}

std::vector<std::size_t> resampled(const Eigen::VectorXd& weights, std::size_t n, RandomStream stream) {
  std::vector<std::size_t> chosen;
  const double start = stream.uniform();
  double sum = 0;
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    sum += weights[i] * static_cast<double>(n);
    while (chosen.size() < n && start + static_cast<double>(chosen.size()) < sum) chosen.push_back(index(i));
  }
  return chosen;
}

Emulator emulator_of(const CalibrationData& data) {
  return Emulator(std::make_shared<const EmulatorBasis>(data.random, data.draws), data.values);
}

Calibration calibrate(const CalibrationData& data, const CalibrationOptions& options, std::uint64_t seed) {
  require_draws(data, 0);
  const Emulator emulator = emulator_of(data);
  const auto n_components = static_cast<double>(emulator.n_components());
  require_draws(data, least_degrees - (emulator.degrees_of_freedom() - n_components + 1));
  const RandomStream stream(seed, 0, "calibrate");
  const CovarianceTerms terms{options.has_discrepancy, options.has_specimen_scatter};
  const SyntheticLikelihood likelihood(emulator, data.observed, terms);
  const PosteriorPoints points = posterior_of(likelihood, full_effort, stream.substream(0));
  const InputTable& table = emulator.basis().table;
  Calibration found{.options = options, .bits = points.bits, .notes = data.notes};
  const auto posteriors = input_spreads(table, points);
  for (std::size_t k = 0; k < data.random.size(); ++k)
    found.inputs.push_back({data.random[k], prior_of(table, k), posteriors[k]});
  found.correlation = correlations(table, points, found.inputs);
  add_draws(table, points, stream.substream(1), found);
  add_scales(data, likelihood, points, found);
  add_predictions(data, likelihood, points, stream.substream(2), found);
  found.contributions = contributions(data, emulator, terms, stream.substream(3));
  found.checks = calibration_checks(data, emulator, stream.substream(4));
  found.checks.effective_size = points.effective_size;
  found.n_draws = data.draws.size();
  found.n_used = data.values.draw.size();
  found.left_out = data.left_out;
  found.warnings = check_warnings(found);
  return found;
}

Calibration calibrate(std::span<const Experiment> experiments, const ObservedSamples& samples,
                      const geometry::Body& body, const input::Parameters& parameters,
                      const CalibrationOptions& options) {
  if (parameters.random.empty())
    fail("the ensemble has no random inputs; only those, [[random]] in its input, can be calibrated");
  const CalibrationData data = calibration_data(experiments, samples, body, parameters);
  if (options.has_specimen_scatter && data.observed.contrasts.rows() == 0)
    fail("--between-specimens needs two experiments with the same observations");
  Calibration found = calibrate(data, options, samples.seed);
  for (const std::size_t i : data.experiments) found.experiments.push_back(experiments[i].name);
  found.n_planned = samples.n_planned;
  found.failed = samples.failed;
  found.undecided = samples.undecided;
  found.missing = samples.missing;
  const auto warnings = sample_warnings(parameters, found);
  found.warnings.insert(found.warnings.begin(), warnings.begin(), warnings.end());
  return found;
}

}  // namespace crackle::experiment
