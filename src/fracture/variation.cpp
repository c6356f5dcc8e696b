// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/variation.h"

#include "common/index.h"
#include "common/random.h"
#include "common/vector.h"
#include "fracture/gaussian_field.h"
#include "geometry/quality.h"

#include <fmt/format.h>
#include <boost/math/special_functions/erf.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
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

/// The quantile of a distribution at the probability of a standard normal number.
double factor_at(double normal, input::Distribution distribution, double modulus, double variation) {
  if (distribution == input::Distribution::weibull) return std::pow(exponential_of(normal), 1 / modulus);
  const double log_variance = std::log1p(variation * variation);
  return std::exp(std::sqrt(log_variance) * normal - log_variance / 2);
}

std::vector<double> correlated(const RandomStream& stream, double length, const TetrahedronSpan& tetrahedra) {
  std::vector<geometry::Point> centroids;
  centroids.reserve(tetrahedra.tetrahedra.size());
  for (const auto& t : tetrahedra.tetrahedra) centroids.push_back(geometry::centroid(tetrahedra.nodes, t));
  return GaussianField(stream, length).at(centroids);
}

/// The random number of a tetrahedron in [0, 1).
double uniform_of(const RandomStream& stream, const TetrahedronSpan& tetrahedra, std::size_t i) {
  const auto number = tetrahedra.number.empty() ? static_cast<std::int64_t>(i) : tetrahedra.number[i];
  return stream.substream(static_cast<std::uint64_t>(number)).uniform();
}

/// Standard normal numbers behind the factors.
std::vector<double> normals(const RandomStream& stream, double length, const TetrahedronSpan& tetrahedra) {
  if (length > 0) return correlated(stream, length, tetrahedra);
  std::vector<double> values;
  values.reserve(tetrahedra.tetrahedra.size());
  for (std::size_t i = 0; i < tetrahedra.tetrahedra.size(); ++i) {
    const double u = std::max(uniform_of(stream, tetrahedra, i), std::numeric_limits<double>::min());
    values.push_back(-std::numbers::sqrt2 * boost::math::erfc_inv(2 * u));
  }
  return values;
}

std::vector<double> independent(const input::Variation& variation, const RandomStream& stream,
                                const TetrahedronSpan& tetrahedra) {
  std::vector<double> factors;
  factors.reserve(tetrahedra.tetrahedra.size());
  for (std::size_t i = 0; i < tetrahedra.tetrahedra.size(); ++i) {
    const auto corner = [&](std::size_t k) { return tetrahedra.nodes[index(tetrahedra.tetrahedra[i][k])]; };
    const double volume = geometry::signed_volume(corner(0), corner(1), corner(2), corner(3));
    const double exponential = -std::log1p(-uniform_of(stream, tetrahedra, i));
    factors.push_back(std::pow(variation.reference_volume / volume * exponential, 1 / variation.modulus));
  }
  return factors;
}

RandomStream strength_stream(const input::MaterialModel& model, std::uint64_t sample) {
  return {model.seed, sample, "fracture variation"};
}

}  // namespace

std::vector<double> variation_factors(const input::MaterialModel& model, std::uint64_t sample,
                                      const TetrahedronSpan& tetrahedra) {
  const auto& variation = model.fracture.variation;
  if (!variation) return std::vector<double>(tetrahedra.tetrahedra.size(), 1);
  const RandomStream stream = strength_stream(model, sample);
  if (variation->correlation_length == 0) {
    auto factors = independent(*variation, stream, tetrahedra);
    for (double& factor : factors) factor = rounded(factor);
    return factors;
  }
  auto factors = correlated(stream, variation->correlation_length, tetrahedra);
  for (double& value : factors)
    value = rounded(
        factor_at(value, variation->distribution, variation->modulus, variation->coefficient_of_variation));
  return factors;
}

std::vector<double> stiffness_factors(const input::MaterialModel& model, std::size_t material,
                                      std::uint64_t sample, const TetrahedronSpan& tetrahedra) {
  const auto& variation = model.materials[material].variation;
  if (!variation) return std::vector<double>(tetrahedra.tetrahedra.size(), 1);
  const double length = variation->correlation_length;
  const double shared = variation->with_strength;
  const RandomStream stream(model.seed, sample, fmt::format("material variation {}", material));
  auto factors = normals(stream, length, tetrahedra);
  if (shared != 0) {
    const auto strength = normals(strength_stream(model, sample), length, tetrahedra);
    const double own = std::sqrt(1 - shared * shared);
    for (std::size_t t = 0; t < factors.size(); ++t) factors[t] = shared * strength[t] + own * factors[t];
  }
  for (double& value : factors)
    value = rounded(
        factor_at(value, variation->distribution, variation->modulus, variation->coefficient_of_variation));
  return factors;
}

std::vector<double> strength_factors(const input::MaterialModel& model, std::uint64_t sample,
                                     const TetrahedronSpan& tetrahedra) {
  auto factors = variation_factors(model, sample, tetrahedra);
  const auto& variation = model.fracture.variation;
  if (!variation || variation->of != input::Varies::toughness) return factors;
  // Where both are given, they are independent.
  for (std::size_t t = 0; t < factors.size(); ++t)
    factors[t] = model.fracture_of(tetrahedra.material_of(t)).has_strength_and_toughness()
                     ? 1.0
                     : std::sqrt(factors[t]);
  return factors;
}

std::vector<double> toughness_factors(const input::MaterialModel& model, std::uint64_t sample,
                                      const TetrahedronSpan& tetrahedra) {
  auto factors = variation_factors(model, sample, tetrahedra);
  const auto& variation = model.fracture.variation;
  if (variation && variation->of == input::Varies::strength) std::ranges::fill(factors, 1.0);
  if (variation && variation->of == input::Varies::both)
    for (double& factor : factors) factor *= factor;
  return factors;
}

}  // namespace crackle::fracture
