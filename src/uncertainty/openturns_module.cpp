// SPDX-License-Identifier: GPL-3.0-or-later
// A separate module, loaded if an input has random numbers (openturns.h).
#include "openturns.h"

#include "crackle/common/failure.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <mutex>
#include <openturns/AdaptiveStieltjesAlgorithm.hxx>
#include <openturns/BetaMuSigma.hxx>
#include <openturns/HermiteFactory.hxx>
#include <openturns/LegendreFactory.hxx>
#include <openturns/LogNormalMuSigma.hxx>
#include <openturns/Normal.hxx>
#include <openturns/OrthogonalUniVariatePolynomialFamily.hxx>
#include <openturns/SobolSequence.hxx>
#include <openturns/StandardDistributionPolynomialFactory.hxx>
#include <openturns/Triangular.hxx>
#include <openturns/TruncatedNormal.hxx>
#include <openturns/Uniform.hxx>
#include <openturns/WeibullMin.hxx>

namespace crackle::uncertainty {

namespace {

using input::RandomDistribution;
using input::RandomInput;

double or_else(double value, double otherwise) {
  return std::isnan(value) ? otherwise : value;
}

/// The distribution of a random input's values [SI].
OT::Distribution distribution_of(const RandomInput& random) {
  const double mean = or_else(random.mean, random.own);
  const double deviation = random.standard_deviation;
  // Width in standard deviations beyond which a normal distribution is negligible.
  constexpr double everything = 30;
  switch (random.distribution) {
    case RandomDistribution::normal:
      return OT::Normal(mean, deviation);
    case RandomDistribution::lognormal:
      return OT::LogNormalMuSigma(mean, deviation, or_else(random.lower, 0)).getDistribution();
    case RandomDistribution::uniform:
      return OT::Uniform(random.lower, random.upper);
    case RandomDistribution::triangular: {
      const double center = or_else(random.mean, (random.lower + random.upper) / 2);
      const double mode = or_else(random.mode, 3 * center - random.lower - random.upper);
      return OT::Triangular(random.lower, std::clamp(mode, random.lower, random.upper), random.upper);
    }
    case RandomDistribution::weibull:
      return OT::WeibullMin(random.scale, random.shape, or_else(random.lower, 0));
    case RandomDistribution::beta:
      return OT::BetaMuSigma(mean, deviation, random.lower, random.upper).getDistribution();
    case RandomDistribution::truncated:
      return OT::TruncatedNormal(mean, deviation, or_else(random.lower, mean - everything * deviation),
                                 or_else(random.upper, mean + everything * deviation));
  }
  fail("unknown distribution");
}

/// The variable of the polynomials, and the polynomials.
struct Family {
  OT::OrthogonalUniVariatePolynomialFamily polynomials;
  std::function<double(double value)> variable;
};

Family family_of(const RandomInput& random) {
  switch (random.distribution) {
    case RandomDistribution::normal:
    case RandomDistribution::lognormal:
    case RandomDistribution::weibull:
      return {OT::HermiteFactory(),
              [distribution = distribution_of(random), normal = OT::Normal()](double x) {
                constexpr double least = 1e-15;
                return normal.computeQuantile(std::clamp(distribution.computeCDF(x), least, 1 - least))[0];
              }};
    case RandomDistribution::uniform:
      return {OT::LegendreFactory(), [lower = random.lower, upper = random.upper](double x) {
                return 2 * (x - lower) / (upper - lower) - 1;
              }};
    default:
      break;
  }
  // Normalized values keep the numbers of the recurrence in range.
  const OT::Distribution distribution = distribution_of(random);
  const double center = distribution.getMean()[0], width = distribution.getStandardDeviation()[0];
  const OT::Distribution standard = (distribution - center) / width;
  return {OT::StandardDistributionPolynomialFactory(OT::AdaptiveStieltjesAlgorithm(standard)),
          [center, width](double x) { return (x - center) / width; }};
}

/// Runs `work()` with OpenTURNS, one thread at a time; its errors become std::runtime_error.
template <class Work>
auto with_openturns(Work&& work) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  try {
    return work();
  } catch (const OT::Exception& error) {
    fail("OpenTURNS: {}", error.what());
  }
}

class Loaded final : public OpenTurns {
public:
  double quantile(const RandomInput& random, double probability) const override {
    return with_openturns([&] { return distribution_of(random).computeQuantile(probability)[0]; });
  }

  std::vector<double> sobol_point(std::size_t n_dimensions, std::uint64_t number) const override {
    return with_openturns([&] {
      std::vector<double> point(n_dimensions, 0);
      OT::SobolSequence sequence(n_dimensions);
      if (number == 0) return point;
      // OpenTURNS omits the origin, without which 2^m points are no net (Owen 2020, "On dropping the first
      // Sobol' point").
      const OT::Sample points = sequence.generate(number);
      for (std::size_t k = 0; k < n_dimensions; ++k) point[k] = points(number - 1, k);
      return point;
    });
  }

  std::vector<std::vector<double>> orthonormal_polynomials(const RandomInput& random,
                                                           std::span<const double> values,
                                                           int highest_degree) const override {
    return with_openturns([&] {
      const Family family = family_of(random);
      std::vector<double> variable;
      for (const double value : values) variable.push_back(family.variable(value));
      std::vector<std::vector<double>> table;
      for (int degree = 0; degree <= highest_degree; ++degree) {
        const OT::UniVariatePolynomial polynomial =
            family.polynomials.build(static_cast<OT::UnsignedInteger>(degree));
        auto& row = table.emplace_back();
        for (const double x : variable) row.push_back(polynomial(x));
      }
      return table;
    });
  }
};

}  // namespace

}  // namespace crackle::uncertainty

extern "C" const crackle::uncertainty::OpenTurns* crackle_openturns() {
  static const crackle::uncertainty::Loaded loaded;
  return &loaded;
}
