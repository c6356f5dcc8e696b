// SPDX-License-Identifier: GPL-3.0-or-later
#include "uncertainty/polynomials.h"

#include "common/failure.h"

#include "distribution.h"

#include <boost/math/distributions/normal.hpp>
#include <boost/math/quadrature/tanh_sinh.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

namespace crackle::uncertainty {

namespace {

using input::RandomDistribution;
using input::RandomInput;

/// Coefficients of the recurrence sqrt(b[n + 1]) p[n + 1] = (x - a[n]) p[n] - sqrt(b[n]) p[n - 1] of
/// orthonormal polynomials, p[0] = 1.
struct Recurrence {
  std::vector<double> a, b;
};

std::vector<double> polynomials_at(double x, const Recurrence& recurrence, std::size_t n) {
  std::vector<double> value(n, 1);
  for (std::size_t k = 0; k + 1 < n; ++k) {
    const double before = k > 0 ? std::sqrt(recurrence.b[k]) * value[k - 1] : 0;
    value[k + 1] = ((x - recurrence.a[k]) * value[k] - before) / std::sqrt(recurrence.b[k + 1]);
  }
  return value;
}

/// The mean of a function of a random value.
template <class Function>
double mean_of(const Distribution& distribution, const Function& function) {
  if (!distribution.values.empty()) {
    double sum = 0;
    for (std::size_t i = 0; i < distribution.values.size(); ++i)
      sum += distribution.shares[i] * function(distribution.values[i]);
    return sum;
  }
  boost::math::quadrature::tanh_sinh<double> integrator;
  // Unbounded distributions have no quantile at the ends.
  constexpr double least = 1e-16;
  const auto at = [&](double p) { return function(distribution.quantile(std::clamp(p, least, 1 - least))); };
  const double corner = distribution.corner;
  return (corner > 0 ? integrator.integrate(at, 0.0, corner) : 0) +
         (corner < 1 ? integrator.integrate(at, corner, 1.0) : 0);
}

/// The variable of the polynomials, and the polynomials.
struct Family {
  std::function<double(double value)> variable;
  Recurrence recurrence;
};

Family hermite(const RandomInput& random, std::size_t n) {
  Family family{[distribution = distribution_of(random)](double x) {
                  constexpr double least = 1e-15;
                  return boost::math::quantile(boost::math::normal(),
                                               std::clamp(distribution.cdf(x), least, 1 - least));
                },
                {std::vector<double>(n, 0), {1}}};
  for (std::size_t k = 1; k <= n; ++k) family.recurrence.b.push_back(static_cast<double>(k));
  return family;
}

Family legendre(const RandomInput& random, std::size_t n) {
  Family family{[lower = random.lower, upper = random.upper](double x) {
                  return 2 * (x - lower) / (upper - lower) - 1;
                },
                {std::vector<double>(n, 0), {1}}};
  for (std::size_t k = 1; k <= n; ++k)
    family.recurrence.b.push_back(1 / (4 - 1 / std::pow(static_cast<double>(k), 2)));
  return family;
}

/// By Stieltjes' procedure (Gautschi, Orthogonal Polynomials, 2004, section 2.2).
Family stieltjes(const RandomInput& random, std::size_t n) {
  const Distribution distribution = distribution_of(random);
  // Normalized values keep the numbers of the recurrence in range.
  const double center = mean_of(distribution, [](double x) { return x; });
  const double width = std::sqrt(mean_of(distribution, [&](double x) { return std::pow(x - center, 2); }));
  Family family{[=](double x) { return (x - center) / width; }, {{}, {1}}};
  auto& [a, b] = family.recurrence;
  for (std::size_t k = 0; k < n; ++k) {
    a.push_back(mean_of(distribution, [&](double value) {
      const double x = family.variable(value), p = polynomials_at(x, family.recurrence, k + 1)[k];
      return x * p * p;
    }));
    // With 1 in its place, the mean square of the next polynomial is b.
    b.push_back(1);
    b.back() = mean_of(distribution, [&](double value) {
      return std::pow(polynomials_at(family.variable(value), family.recurrence, k + 2)[k + 1], 2);
    });
  }
  return family;
}

Family family_of(const RandomInput& random, std::size_t n) {
  switch (random.distribution) {
    case RandomDistribution::normal:
    case RandomDistribution::lognormal:
    case RandomDistribution::weibull:
      return hermite(random, n);
    case RandomDistribution::uniform:
      return legendre(random, n);
    case RandomDistribution::triangular:
    case RandomDistribution::beta:
    case RandomDistribution::truncated:
    case RandomDistribution::discrete:
    case RandomDistribution::empirical:
      break;
  }
  return stieltjes(random, n);
}

}  // namespace

int most_degree(const RandomInput& random) {
  if (random.distribution != RandomDistribution::discrete) return std::numeric_limits<int>::max();
  return static_cast<int>(std::set(random.values.begin(), random.values.end()).size()) - 1;
}

std::vector<std::vector<double>> orthonormal_polynomials(const RandomInput& random,
                                                         std::span<const double> values, int highest_degree) {
  const auto n = static_cast<std::size_t>(highest_degree) + 1;
  try {
    const auto n_own = static_cast<std::size_t>(std::min(highest_degree, most_degree(random)));
    const Family family = family_of(random, n_own);
    std::vector<std::vector<double>> table(n);
    for (const double value : values) {
      const auto at = polynomials_at(family.variable(value), family.recurrence, n_own + 1);
      for (std::size_t k = 0; k < n; ++k) table[k].push_back(k <= n_own ? at[k] : 0);
    }
    return table;
  } catch (const std::logic_error& error) {  // std::domain_error of Boost
    fail("the polynomials of {} cannot be made: {}", random.key, error.what());
  }
}

}  // namespace crackle::uncertainty
