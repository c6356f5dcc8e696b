// SPDX-License-Identifier: GPL-3.0-or-later
#include "uncertainty/random_inputs.h"

#include "common/failure.h"
#include "common/quantity_text.h"
#include "common/random.h"
#include "input/copula.h"
#include "input/reader.h"

#include "distribution.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <boost/math/distributions/normal.hpp>
#include <boost/random/sobol.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace crackle::uncertainty {

namespace {

using input::RandomInput;

constexpr int n_bits = 53;

/// The midpoint of one of 2^53 equal subintervals of the unit interval.
double middle_of(std::uint64_t interval) {
  // The last midpoints would round to 1.
  return std::min(std::ldexp(static_cast<double>(interval) + 0.5, -n_bits), 1 - 0x1p-53);
}

std::uint64_t random_interval(RandomStream stream) {
  return stream.bits() >> (64 - n_bits);
}

std::vector<double> independent_point(std::uint64_t seed, std::size_t n_dimensions, std::uint64_t number) {
  const RandomStream stream(seed, number, "random inputs");
  std::vector<double> point(n_dimensions);
  for (std::size_t k = 0; k < n_dimensions; ++k) point[k] = middle_of(random_interval(stream.substream(k)));
  return point;
}

/// The layer of each point in one dimension: a random permutation.
std::vector<std::uint64_t> random_layers(RandomStream stream, std::uint64_t n_points) {
  std::vector<std::uint64_t> layers(n_points);
  std::iota(layers.begin(), layers.end(), 0);
  for (std::uint64_t i = n_points; i > 1; --i) {
    const auto other = static_cast<std::uint64_t>(stream.uniform() * static_cast<double>(i));
    std::swap(layers[i - 1], layers[std::min(other, i - 1)]);
  }
  return layers;
}

std::vector<double> hypercube_point(std::uint64_t seed, std::uint64_t n_points, std::size_t n_dimensions,
                                    std::uint64_t number) {
  if (number >= n_points) fail("a Latin hypercube of {} points has no point {}", n_points, number);
  std::vector<double> point = independent_point(seed, n_dimensions, number);
  const RandomStream layers(seed, 0, "layers of a Latin hypercube");
  for (std::size_t k = 0; k < n_dimensions; ++k) {
    const auto layer = random_layers(layers.substream(k), n_points)[number];
    // The last points can round to 1.
    point[k] = std::min((static_cast<double>(layer) + point[k]) / static_cast<double>(n_points), 1 - 0x1p-53);
  }
  return point;
}

/// With the origin, which Boost leaves out, as without it 2^m points are no net (Owen 2020, "On dropping the
/// first Sobol' point"); and with a random digital shift, which keeps the points a net and moves the origin,
/// where unbounded distributions have no quantile.
std::vector<double> sobol_point(std::uint64_t seed, std::size_t n_dimensions, std::uint64_t number) {
  boost::random::sobol_engine<std::uint64_t, 64> sequence(n_dimensions);
  if (number > 0) sequence.seed(number - 1);
  const RandomStream shifts(seed, 0, "shift of a Sobol sequence");
  std::vector<double> point;
  for (std::size_t k = 0; k < n_dimensions; ++k) {
    const std::uint64_t interval = number > 0 ? sequence() >> (64 - n_bits) : 0;
    point.push_back(middle_of(interval ^ random_interval(shifts.substream(k))));
  }
  return point;
}

/// A point of the unit cube with the correlations of the inputs.
std::vector<double> correlated(const input::Study& study, const std::vector<double>& point) {
  if (study.correlations.empty()) return point;
  const boost::math::normal normal;
  const auto factor = input::copula_factor(study);
  std::vector<double> moved;
  for (const auto& row : factor) {
    double variable = 0;
    for (std::size_t k = 0; k < point.size(); ++k)
      if (row[k] != 0) variable += row[k] * boost::math::quantile(normal, point[k]);
    moved.push_back(std::clamp(boost::math::cdf(normal, variable), 0x1p-53, 1 - 0x1p-53));
  }
  return moved;
}

}  // namespace

double quantile(const RandomInput& random, double probability) {
  try {
    return distribution_of(random).quantile(probability);
  } catch (const std::logic_error& error) {  // std::domain_error of Boost
    fail("{} has no quantile of {}: {}", random.key, probability, error.what());
  }
}

std::vector<double> plan_point(input::SamplingPlan plan, std::uint64_t seed, std::uint64_t n_points,
                               std::size_t n_dimensions, std::uint64_t number) {
  switch (plan) {
    case input::SamplingPlan::independent:
      return independent_point(seed, n_dimensions, number);
    case input::SamplingPlan::latin_hypercube:
      return hypercube_point(seed, n_points, n_dimensions, number);
    case input::SamplingPlan::sobol:
      return sobol_point(seed, n_dimensions, number);
  }
  fail("unknown plan");
}

std::vector<double> drawn_values(const input::Study& study, std::uint64_t sample) {
  const auto& [ensemble, random] = std::tie(study.ensemble, study.random);
  if (random.empty()) return {};
  const std::vector<double> point = correlated(
      study,
      plan_point(ensemble.plan, study.seed, ensemble.n_inputs(), random.size(), ensemble.input_of(sample)));
  std::vector<double> values;
  for (std::size_t k = 0; k < random.size(); ++k)
    values.push_back(to_six_digits(quantile(random[k], point[k])));
  return values;
}

input::Parameters sample_parameters(const input::Parameters& parameters, std::uint64_t sample) {
  if (parameters.random.empty()) return parameters;
  const std::vector<double> values = drawn_values(parameters, sample);
  try {
    return input::drawn(parameters, values, "input.toml");
  } catch (const input::InputError& error) {
    std::vector<std::string> drawn;
    for (std::size_t k = 0; k < values.size(); ++k)
      drawn.push_back(
          fmt::format("{} = {}", parameters.random[k].key, format_value(parameters.random[k], values[k])));
    fail("the drawn values do not give a valid input ({}): {}", fmt::join(drawn, ", "),
         fmt::join(error.messages(), "; "));
  }
}

}  // namespace crackle::uncertainty
