// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

/// Compares samples with their expected distributions.
namespace crackle::test {

/// The largest distance between the values' empirical distribution and the expected one (Kolmogorov-Smirnov).
template <class Distribution>
double kolmogorov_distance(std::vector<double> values, const Distribution& expected) {
  std::ranges::sort(values);
  const auto n = static_cast<double>(values.size());
  double distance = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double p = expected(values[i]);
    if (!(p >= 0 && p <= 1)) return 1;  // a value is NaN
    const auto rank = static_cast<double>(i);
    distance = std::max({distance, p - rank / n, (rank + 1) / n - p});
  }
  return distance;
}

/// Limit exceeded by one sample of n in a thousand (Kolmogorov).
inline double kolmogorov_limit(std::size_t n) {
  return 1.95 / std::sqrt(static_cast<double>(n));
}

/// Weibull modulus and scale by maximum likelihood.
struct WeibullFit {
  double modulus, scale;
  double standard_error;  ///< of the modulus
};

inline WeibullFit fit_weibull(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double mean_log = 0;
  for (const double value : values) mean_log += std::log(value) / n;
  const double unit = std::exp(mean_log);
  double modulus = 5;
  for (int i = 0; i < 50; ++i) {  // Newton's method for the derivative of the likelihood
    double s = 0, s_log = 0, s_log_log = 0;
    for (const double value : values) {
      const double log = std::log(value / unit);
      const double power = std::pow(value / unit, modulus);
      s += power;
      s_log += power * log;
      s_log_log += power * log * log;
    }
    const double f = s_log / s - 1 / modulus;
    const double slope = s_log_log / s - s_log * s_log / (s * s) + 1 / (modulus * modulus);
    modulus = std::max(modulus / 3, modulus - f / slope);
  }
  double mean_power = 0;
  for (const double value : values) mean_power += std::pow(value / unit, modulus) / n;
  return {modulus, unit * std::pow(mean_power, 1 / modulus), 0.78 * modulus / std::sqrt(n)};
}

}  // namespace crackle::test
