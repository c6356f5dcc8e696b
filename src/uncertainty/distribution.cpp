// SPDX-License-Identifier: GPL-3.0-or-later
#include "distribution.h"

#include "common/failure.h"

#include <boost/math/distributions/beta.hpp>
#include <boost/math/distributions/lognormal.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/triangular.hpp>
#include <boost/math/distributions/uniform.hpp>
#include <boost/math/distributions/weibull.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace crackle::uncertainty {

namespace {

using input::RandomDistribution;
using input::RandomInput;

double or_else(double value, double otherwise) {
  return std::isnan(value) ? otherwise : value;
}

/// The values offset + factor X of a variable X.
template <class Standard>
Distribution scaled(const Standard& standard, double offset, double factor) {
  return {[=](double p) { return offset + factor * boost::math::quantile(standard, p); },
          [=](double x) { return boost::math::cdf(standard, (x - offset) / factor); }, 0};
}

/// Of the logarithm's mean and deviation, such that the values above `lower` have this mean and deviation.
Distribution lognormal(double mean, double deviation, double lower) {
  const double variance = std::log1p(std::pow(deviation / (mean - lower), 2));
  return scaled(boost::math::lognormal(std::log(mean - lower) - variance / 2, std::sqrt(variance)), lower, 1);
}

Distribution beta(double mean, double deviation, double lower, double upper) {
  const double width = upper - lower, m = (mean - lower) / width;
  const double sum = m * (1 - m) / std::pow(deviation / width, 2) - 1;
  return scaled(boost::math::beta_distribution<>(m * sum, (1 - m) * sum), lower, width);
}

Distribution triangular(const RandomInput& random) {
  const double center = or_else(random.mean, (random.lower + random.upper) / 2);
  const double mode = or_else(random.mode, 3 * center - random.lower - random.upper);
  const double peak = std::clamp(mode, random.lower, random.upper);
  Distribution result = scaled(boost::math::triangular(random.lower, peak, random.upper), 0, 1);
  result.corner = result.cdf(peak);
  return result;
}

/// A normal distribution between two limits; NaN: none. Probabilities are counted from the side of the nearer
/// tail, where they keep their digits.
Distribution truncated(double mean, double deviation, double lower, double upper) {
  const boost::math::normal standard;
  const bool is_mirrored = !std::isnan(lower) && lower > mean;
  const double sign = is_mirrored ? -1 : 1;
  const auto share_below = [=](double limit, double none) {
    return std::isnan(limit) ? none : boost::math::cdf(standard, sign * (limit - mean) / deviation);
  };
  const double below = is_mirrored ? share_below(upper, 0) : share_below(lower, 0);
  const double width = (is_mirrored ? share_below(lower, 1) : share_below(upper, 1)) - below;
  return {[=](double p) {
            const double q = below + width * (is_mirrored ? 1 - p : p);
            const double value = mean + sign * deviation * boost::math::quantile(standard, q);
            return std::fmin(std::fmax(value, lower), upper);
          },
          [=](double x) {
            const double share = (share_below(x, 0) - below) / width;
            return is_mirrored ? 1 - share : share;
          },
          0};
}

/// Some values by their weights; the share below a value counts half of its own.
Distribution discrete(const RandomInput& random) {
  std::map<double, double> weight;
  for (std::size_t i = 0; i < random.values.size(); ++i)
    weight[random.values[i]] += random.weights.empty() ? 1 : random.weights[i];
  double sum = 0;
  for (const auto& [value, own] : weight) sum += own;
  std::vector<double> values, shares;
  for (const auto& [value, own] : weight) {
    values.push_back(value);
    shares.push_back(own / sum);
  }
  Distribution result;
  result.quantile = [=](double p) {
    double below = 0;
    for (std::size_t i = 0; i + 1 < values.size(); ++i)
      if ((below += shares[i]) >= p) return values[i];
    return values.back();
  };
  result.cdf = [=](double x) {
    double below = 0;
    for (std::size_t i = 0; i < values.size() && values[i] <= x; ++i)
      below += values[i] < x ? shares[i] : shares[i] / 2;
    return below;
  };
  result.values = values;
  result.shares = shares;
  return result;
}

/// Linear between measured values in order.
Distribution empirical(const RandomInput& random) {
  std::vector<double> values = random.values;
  std::ranges::sort(values);
  const auto n = static_cast<double>(values.size() - 1);
  Distribution result;
  result.quantile = [=](double p) {
    const auto left = std::min(static_cast<std::size_t>(p * n), values.size() - 2);
    return std::lerp(values[left], values[left + 1], p * n - static_cast<double>(left));
  };
  result.cdf = [=](double x) {
    const auto above = std::ranges::upper_bound(values, x) - values.begin();
    if (above == 0) return 0.0;
    if (above == std::ssize(values)) return 1.0;
    const auto i = static_cast<std::size_t>(above);
    return (static_cast<double>(above - 1) + (x - values[i - 1]) / (values[i] - values[i - 1])) / n;
  };
  // Its quantile has a corner at each value.
  constexpr int n_nodes = 20'000;
  for (int i = 0; i < n_nodes; ++i) {
    result.values.push_back(result.quantile((i + 0.5) / n_nodes));
    result.shares.push_back(1.0 / n_nodes);
  }
  return result;
}

}  // namespace

Distribution distribution_of(const RandomInput& random) {
  const double mean = or_else(random.mean, random.own);
  const double deviation = random.standard_deviation;
  switch (random.distribution) {
    case RandomDistribution::normal:
      return scaled(boost::math::normal(), mean, deviation);
    case RandomDistribution::lognormal:
      return lognormal(mean, deviation, or_else(random.lower, 0));
    case RandomDistribution::uniform:
      return scaled(boost::math::uniform(0, 1), random.lower, random.upper - random.lower);
    case RandomDistribution::triangular:
      return triangular(random);
    case RandomDistribution::weibull:
      return scaled(boost::math::weibull(random.shape, random.scale), or_else(random.lower, 0), 1);
    case RandomDistribution::beta:
      return beta(mean, deviation, random.lower, random.upper);
    case RandomDistribution::truncated:
      return truncated(mean, deviation, random.lower, random.upper);
    case RandomDistribution::discrete:
      return discrete(random);
    case RandomDistribution::empirical:
      return empirical(random);
  }
  fail("unknown distribution");
}

}  // namespace crackle::uncertainty
