// SPDX-License-Identifier: GPL-3.0-or-later
// The posterior as [[random]] tables of an input.
#include "crackle/common/index.h"
#include "crackle/common/quantity_text.h"
#include "crackle/experiment/calibration.h"
#include "crackle/input/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace crackle::experiment {

namespace {

using input::RandomDistribution;
using input::RandomInput;

/// Smaller correlations are not worth a line.
constexpr double least_correlation = 0.1;

/// Where an increasing function has a value, between two numbers.
double inverse(const std::function<double(double)>& function, double value, double lower, double upper) {
  for (int step = 0; step < 100; ++step) {
    const double middle = (lower + upper) / 2;
    (function(middle) < value ? lower : upper) = middle;
  }
  return (lower + upper) / 2;
}

/// The Weibull distribution from `lower` on with a mean and a standard deviation.
void fit_weibull(const Spread& posterior, double lower, RandomInput& random) {
  const double mean = posterior.mean - lower, wanted = mean / posterior.standard_deviation;
  random.shape = inverse(
      [](double shape) {
        const double first = std::lgamma(1 + 1 / shape), second = std::lgamma(1 + 2 / shape);
        return 1 / std::sqrt(std::expm1(second - 2 * first));
      },
      wanted, 0.2, 1000);
  random.scale = mean / std::tgamma(1 + 1 / random.shape);
}

/// The normal distribution that has a mean and a standard deviation when it is cut off on one side.
/// @param distance of the mean from the bound, and on which side it lies: 1 above, -1 below
void fit_truncated(const Spread& posterior, double bound, double side, RandomInput& random) {
  // In the normal distribution's own standard deviations its mean lies `a` from the bound.
  const auto hazard = [](double a) {
    return std::exp(-a * a / 2) / std::sqrt(2 * std::numbers::pi) / (std::erfc(-a / std::numbers::sqrt2) / 2);
  };
  const auto deviation = [&](double a) { return std::sqrt(1 - hazard(a) * (hazard(a) + a)); };
  const double wanted = side * (posterior.mean - bound) / posterior.standard_deviation;
  const double a = inverse([&](double x) { return (x + hazard(x)) / deviation(x); }, wanted, -10,
                           std::max(10.0, 2 * wanted));
  random.standard_deviation = posterior.standard_deviation / deviation(a);
  random.mean = bound + side * a * random.standard_deviation;
}

/// The distribution that the posterior is written as.
RandomInput fitted(const CalibratedInput& input) {
  const RandomInput& prior = input.random;
  RandomInput random{.key = prior.key, .unit = prior.unit, .moved = prior.moved, .exponent = prior.exponent};
  random.distribution = prior.distribution;
  random.lower = prior.lower;
  random.upper = prior.upper;
  random.mean = input.posterior.mean;
  random.standard_deviation = input.posterior.standard_deviation;
  switch (prior.distribution) {
    case RandomDistribution::normal:
    case RandomDistribution::lognormal:
    case RandomDistribution::beta:
      break;
    case RandomDistribution::uniform:
    case RandomDistribution::triangular:
      random.distribution = RandomDistribution::beta;
      break;
    case RandomDistribution::weibull:
      random.mean = random.standard_deviation = not_a_number;
      fit_weibull(input.posterior, std::isnan(prior.lower) ? 0 : prior.lower, random);
      break;
    case RandomDistribution::truncated:
      if (!std::isnan(prior.lower) && !std::isnan(prior.upper))
        random.distribution = RandomDistribution::beta;
      else if (!std::isnan(prior.lower))
        fit_truncated(input.posterior, prior.lower, 1, random);
      else
        fit_truncated(input.posterior, prior.upper, -1, random);
      break;
  }
  return random;
}

std::string table_of(const RandomInput& random) {
  std::string keys = fmt::format("\"{}\"", random.key);
  for (const input::MovedNumber& each : random.moved) keys += fmt::format(", \"{}\"", each.key);
  if (!random.moved.empty()) keys = "[" + keys + "]";
  std::string text = fmt::format("[[random]]\nkey = {}\ndistribution = \"{}\"\n", keys,
                                 input::distribution_names[index(random.distribution)]);
  const auto add = [&](const char* name, double value) {
    if (std::isnan(value)) return;
    const std::string shown = format_value(random, value);
    text += fmt::format(fmt::runtime(random.unit.empty() ? "{} = {}\n" : "{} = \"{}\"\n"), name, shown);
  };
  add("mean", to_six_digits(random.mean));
  add("standard_deviation", to_six_digits(random.standard_deviation));
  add("lower", random.lower);
  add("upper", random.upper);
  add("scale", to_six_digits(random.scale));
  if (!std::isnan(random.shape)) text += fmt::format("shape = {}\n", to_six_digits(random.shape));
  return text;
}

}  // namespace

std::string posterior_tables(const Calibration& found) {
  std::string text =
      "# Posterior of the random inputs, from crackle calibrate: to be put in the place of the [[random]] "
      "tables\n"
      "# of an input. Means and standard deviations are the posterior's. Its shape and its correlations are "
      "lost";
  std::string lost;
  for (std::size_t i = 0; i < found.inputs.size(); ++i)
    for (std::size_t k = i + 1; k < found.inputs.size(); ++k)
      if (std::abs(found.correlation[i][k]) >= least_correlation)
        lost += fmt::format("#   {:+.2f} of {} and {}\n", found.correlation[i][k], found.inputs[i].random.key,
                            found.inputs[k].random.key);
  text += lost.empty() ? fmt::format(",\n# all below {}.\n", least_correlation) : ":\n" + lost;
  for (const CalibratedInput& each : found.inputs) text += table_of(fitted(each));
  return text;
}

}  // namespace crackle::experiment
