// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/fracture/variation.h"

#include "crackle/common/index.h"
#include "crackle/common/random.h"
#include "crackle/common/vector.h"
#include "crackle/fracture/gaussian_field.h"
#include "crackle/geometry/centroid.h"
#include "crackle/geometry/quality.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace crackle::fracture {

namespace {

constexpr double least_factor = 0x1p-20;  ///< keeps every strength positive

double rounded(double factor) {
  int exponent = 0;
  const double fraction = std::frexp(std::max(factor, least_factor), &exponent);
  return std::ldexp(std::rint(std::ldexp(fraction, 16)), exponent - 16);
}

/// -ln of the probability that a standard normal number is greater: exponentially distributed.
double exponential_of(double normal) {
  return -std::log(std::erfc(normal / std::numbers::sqrt2) / 2);
}

std::vector<double> correlated(const input::Variation& variation, const RandomStream& stream,
                               const TetrahedronSpan& tetrahedra) {
  std::vector<geometry::Point> centroids;
  centroids.reserve(tetrahedra.tetrahedra.size());
  for (const auto& t : tetrahedra.tetrahedra) centroids.push_back(geometry::centroid(tetrahedra.nodes, t));
  std::vector<double> factors = GaussianField(stream, variation.correlation_length).at(centroids);
  const double cv = variation.coefficient_of_variation;
  const double log_variance = std::log1p(cv * cv);
  for (double& value : factors)
    value = variation.distribution == input::Distribution::weibull
                ? std::pow(exponential_of(value), 1 / variation.modulus)
                : std::exp(std::sqrt(log_variance) * value - log_variance / 2);
  return factors;
}

std::vector<double> independent(const input::Variation& variation, const RandomStream& stream,
                                const TetrahedronSpan& tetrahedra) {
  std::vector<double> factors;
  factors.reserve(tetrahedra.tetrahedra.size());
  for (std::size_t i = 0; i < tetrahedra.tetrahedra.size(); ++i) {
    const auto corner = [&](std::size_t k) { return tetrahedra.nodes[index(tetrahedra.tetrahedra[i][k])]; };
    const double volume = geometry::signed_volume(corner(0), corner(1), corner(2), corner(3));
    const auto number = static_cast<std::uint64_t>(tetrahedra.number.empty() ? static_cast<std::int64_t>(i)
                                                                             : tetrahedra.number[i]);
    const double exponential = -std::log1p(-stream.substream(number).uniform());
    factors.push_back(std::pow(variation.reference_volume / volume * exponential, 1 / variation.modulus));
  }
  return factors;
}

}  // namespace

std::vector<double> variation_factors(const input::Parameters& parameters, std::uint64_t sample,
                                      const TetrahedronSpan& tetrahedra) {
  const auto& variation = parameters.fracture.variation;
  if (!variation) return std::vector<double>(tetrahedra.tetrahedra.size(), 1);
  const RandomStream stream(parameters.ensemble.seed, sample, "fracture variation");
  auto factors = variation->correlation_length > 0 ? correlated(*variation, stream, tetrahedra)
                                                   : independent(*variation, stream, tetrahedra);
  for (double& factor : factors) factor = rounded(factor);
  return factors;
}

std::vector<double> strength_factors(const input::Parameters& parameters, std::uint64_t sample,
                                     const TetrahedronSpan& tetrahedra) {
  auto factors = variation_factors(parameters, sample, tetrahedra);
  const auto& variation = parameters.fracture.variation;
  if (!variation || variation->of != input::Varies::toughness) return factors;
  // Where both are given, they are independent.
  if (parameters.fracture.has_strength_and_toughness())
    std::ranges::fill(factors, 1.0);
  else
    for (double& factor : factors) factor = std::sqrt(factor);
  return factors;
}

std::vector<double> toughness_factors(const input::Parameters& parameters, std::uint64_t sample,
                                      const TetrahedronSpan& tetrahedra) {
  auto factors = variation_factors(parameters, sample, tetrahedra);
  const auto& variation = parameters.fracture.variation;
  if (variation && variation->of == input::Varies::strength) std::ranges::fill(factors, 1.0);
  if (variation && variation->of == input::Varies::both)
    for (double& factor : factors) factor *= factor;
  return factors;
}

}  // namespace crackle::fracture
