// SPDX-License-Identifier: GPL-3.0-or-later
// Random fields of the material: moments, correlation, marginal distributions, and independence of a factor
// from the partition.
#include "fracture/gaussian_field.h"
#include "fracture/variation.h"

#include "support/box_mesh.h"
#include "support/distributions.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace crackle::fracture {
namespace CRACKLE_TEST_FILE {

using input::Distribution;
using input::Varies;

constexpr double length = 2e-3;  // correlation length [m]

double normal_distribution(double x) {
  return std::erfc(-x / std::numbers::sqrt2) / 2;
}

TEST(GaussianField, IsStandardNormalWithMaternsCorrelation) {
  constexpr int n_fields = 4000;
  const std::vector<double> distances{0, 0.25, 0.5, 1, 2, 4};  // in correlation lengths
  std::vector<geometry::Point> points;
  for (const double d : distances)
    points.push_back({0.3e-3 + d * length / 3, 1e-3 + d * length * 2 / 3, 5e-3 - d * length * 2 / 3});
  std::vector<double> at_first;
  std::vector<double> products(distances.size(), 0);
  for (int i = 0; i < n_fields; ++i) {
    const GaussianField field(RandomStream(7, static_cast<std::uint64_t>(i), "test"), length);
    const auto values = field.at(points);
    at_first.push_back(values[0]);
    for (std::size_t k = 0; k < values.size(); ++k) products[k] += values[0] * values[k] / n_fields;
  }
  const double error = test::kolmogorov_distance(at_first, normal_distribution);
  std::printf("distance from the normal distribution %.4f (99.9 %%: %.4f)\n", error,
              test::kolmogorov_limit(n_fields));
  EXPECT_LT(error, test::kolmogorov_limit(n_fields));
  for (std::size_t k = 0; k < distances.size(); ++k) {
    const double expected = matern_correlation(distances[k] * length, length);
    // The product of two normal numbers with this correlation has variance 1 + expected^2.
    const double standard_error = std::sqrt((1 + expected * expected) / n_fields);
    std::printf("correlation at %.2f lengths: %.4f, expected %.4f +- %.4f\n", distances[k], products[k],
                expected, standard_error);
    EXPECT_NEAR(products[k], expected, 4 * standard_error);
  }
}

TEST(GaussianField, VariesWithinItselfAsOverTheEnsemble) {
  // One field over many correlation lengths.
  std::vector<geometry::Point> points;
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 40; ++j)
      for (int k = 0; k < 10; ++k) points.push_back({i * length, j * length, k * length});
  const auto values = GaussianField(RandomStream(1, 2, "test"), length).at(points);
  double mean = 0;
  double square = 0;
  for (const double value : values) {
    mean += value / static_cast<double>(values.size());
    square += value * value / static_cast<double>(values.size());
  }
  std::printf("one field at %zu points: mean %.3f, variance %.3f\n", values.size(), mean,
              square - mean * mean);
  EXPECT_NEAR(mean, 0, 0.1);
  EXPECT_NEAR(square - mean * mean, 1, 0.2);
}

input::Parameters varied(input::Variation variation) {
  input::Parameters parameters;
  parameters.seed = 5;
  parameters.fracture.strength = 35e6;
  parameters.fracture.variation = variation;
  return parameters;
}

input::Variation weibull_without_length() {
  return {.distribution = Distribution::weibull, .modulus = 8, .reference_volume = 1e-9};
}
input::Variation weibull_with_length() {
  return {.distribution = Distribution::weibull, .modulus = 8, .correlation_length = length};
}
input::Variation lognormal() {
  return {
      .distribution = Distribution::lognormal, .coefficient_of_variation = 0.3, .correlation_length = length};
}

/// One tetrahedron in each of many samples.
std::vector<double> factors_of_samples(const input::Variation& variation, double edge, int n_samples) {
  const std::vector<geometry::Point> nodes{{0, 0, 0}, {edge, 0, 0}, {0, edge, 0}, {0, 0, edge}};
  const std::vector<geometry::Tetrahedron> tetrahedra{{0, 1, 2, 3}};
  std::vector<double> factors;
  for (int sample = 0; sample < n_samples; ++sample)
    factors.push_back(
        variation_factors(varied(variation), static_cast<std::uint64_t>(sample), {nodes, tetrahedra})
            .front());
  return factors;
}

TEST(Variation, HasTheDistributionThatIsAskedFor) {
  constexpr int n = 4000;
  const double edge = 0.3e-3;
  const double volume = edge * edge * edge / 6;
  const auto weibull = [](double scale) {
    return [=](double x) { return 1 - std::exp(-std::pow(x / scale, 8)); };
  };
  const double spread = std::log1p(0.3 * 0.3);
  const auto check = [&](const char* name, const input::Variation& variation, const auto& expected) {
    const double error = test::kolmogorov_distance(factors_of_samples(variation, edge, n), expected);
    std::printf("%s: distance from the distribution %.4f (99.9 %%: %.4f)\n", name, error,
                test::kolmogorov_limit(n));
    EXPECT_LT(error, test::kolmogorov_limit(n)) << name;
  };
  check("Weibull of a volume", weibull_without_length(), weibull(std::pow(1e-9 / volume, 1.0 / 8)));
  check("Weibull with a correlation length", weibull_with_length(), weibull(1));
  check("lognormal", lognormal(),
        [&](double x) { return normal_distribution((std::log(x) + spread / 2) / std::sqrt(spread)); });
}

TEST(Variation, OfTheToughnessIsTheSquareOfTheStrengths) {
  const auto mesh = test::make_box({.size = {2e-3, 2e-3, 4e-3}, .cells = {2, 2, 4}});
  for (auto variation : {weibull_without_length(), weibull_with_length(), lognormal()}) {
    const TetrahedronSpan all{mesh.nodes, mesh.tetrahedra};
    const auto strength = strength_factors(varied(variation), 3, all);
    variation.of = Varies::both;
    EXPECT_EQ(strength_factors(varied(variation), 3, all), strength);
    variation.of = Varies::toughness;
    const auto root = strength_factors(varied(variation), 3, all);
    for (std::size_t t = 0; t < root.size(); ++t) EXPECT_DOUBLE_EQ(root[t] * root[t], strength[t]);
  }
}

/// Softening has a strength and a toughness: either can vary with the field, or both together.
TEST(Variation, MultipliesStrengthAndToughnessOnTheirOwn) {
  const auto mesh = test::make_box({.size = {2e-3, 2e-3, 4e-3}, .cells = {2, 2, 4}});
  const TetrahedronSpan all{mesh.nodes, mesh.tetrahedra};
  const std::vector<double> ones(mesh.tetrahedra.size(), 1.0);
  auto variation = lognormal();
  const auto factors = [&](Varies of) {
    variation.of = of;
    auto parameters = varied(variation);
    parameters.fracture.strength = 35e6;
    parameters.fracture.toughness = 60;  // with both given, they vary independently
    return std::pair{strength_factors(parameters, 3, all), toughness_factors(parameters, 3, all)};
  };
  const auto field = variation_factors(varied(variation), 3, all);
  EXPECT_EQ(factors(Varies::strength), (std::pair{field, ones}));
  EXPECT_EQ(factors(Varies::toughness), (std::pair{ones, field}));
  // They may as well be those of the material.
  variation.of = Varies::toughness;
  auto of_material = varied(variation);
  of_material.fracture.strength = 0;
  of_material.materials[0].strength = 35e6;
  of_material.materials[0].toughness = 60;
  EXPECT_EQ(strength_factors(of_material, 3, all), ones);
  const auto [strength, toughness] = factors(Varies::both);
  EXPECT_EQ(strength, field);
  for (std::size_t t = 0; t < field.size(); ++t) EXPECT_EQ(toughness[t], field[t] * field[t]);
}

TEST(Variation, BelongsToThePlaceAndTheSample) {
  const auto mesh = test::make_box({.size = {2e-3, 2e-3, 4e-3}, .cells = {3, 3, 6}, .disturbance = 0.1});
  for (const auto& variation : {weibull_without_length(), weibull_with_length(), lognormal()}) {
    const auto whole = variation_factors(varied(variation), 3, {mesh.nodes, mesh.tetrahedra});
    // The tetrahedra of a part, with their numbers in the realization.
    std::vector<geometry::Tetrahedron> some;
    std::vector<std::int64_t> numbers;
    for (std::size_t t = 1; t < mesh.tetrahedra.size(); t += 7) {
      some.push_back(mesh.tetrahedra[t]);
      numbers.push_back(static_cast<std::int64_t>(t));
    }
    const auto part = variation_factors(varied(variation), 3, {mesh.nodes, some, numbers});
    for (std::size_t i = 0; i < part.size(); ++i)
      EXPECT_EQ(part[i], whole[static_cast<std::size_t>(numbers[i])]);
    EXPECT_NE(variation_factors(varied(variation), 4, {mesh.nodes, mesh.tetrahedra}), whole);
    for (const double factor : whole) {
      int exponent = 0;
      const double bits = std::ldexp(std::frexp(factor, &exponent), 16);
      EXPECT_EQ(bits, std::rint(bits));
    }
  }
}

/// Mean of ln f and of its product with ln g, for standardized logarithms.
double correlation(const std::vector<double>& f, const std::vector<double>& g) {
  std::array<double, 5> sums{};
  for (std::size_t i = 0; i < f.size(); ++i) {
    const double x = std::log(f[i]), y = std::log(g[i]);
    for (std::size_t k = 0; k < sums.size(); ++k)
      sums[k] += std::array{x, y, x * x, y * y, x * y}[k] / static_cast<double>(f.size());
  }
  return (sums[4] - sums[0] * sums[1]) /
         std::sqrt((sums[2] - sums[0] * sums[0]) * (sums[3] - sums[1] * sums[1]));
}

TEST(StiffnessVariation, HasItsDistributionAndItsCorrelationWithTheStrength) {
  const auto mesh = test::make_box({.size = {0.01, 0.02, 0.04}, .cells = {10, 20, 40}, .disturbance = 0.2});
  const TetrahedronSpan all{mesh.nodes, mesh.tetrahedra};
  for (const double correlation_length : {0.0, 1e-3})
    for (const double shared : {-1.0, 0.0, 0.6}) {
      auto parameters = varied({.of = Varies::strength,
                                .distribution = Distribution::weibull,
                                .modulus = 8,
                                .reference_volume = 1e-9,
                                .correlation_length = correlation_length});
      parameters.materials[0].variation = {.distribution = Distribution::lognormal,
                                           .coefficient_of_variation = 0.2,
                                           .correlation_length = correlation_length,
                                           .with_strength = shared};
      const auto factors = stiffness_factors(parameters, 0, 3, all);
      double mean = 0, square = 0;
      for (const double f : factors) {
        mean += f / static_cast<double>(factors.size());
        square += f * f / static_cast<double>(factors.size());
      }
      const double variation = std::sqrt(square / (mean * mean) - 1);
      // The logarithm of a Weibull factor is not normal, so its correlation with a normal one is smaller.
      // That of a tetrahedron's weakest point also varies with the volume.
      const double with_strength = correlation(factors, variation_factors(parameters, 3, all));
      const double largest = correlation_length > 0 ? 0.95 : 0.9;
      std::printf("length %.0f mm, with_strength %.1f: mean %.3f, variation %.3f, correlation %.3f\n",
                  1e3 * correlation_length, shared, mean, variation, with_strength);
      EXPECT_NEAR(mean, 1, correlation_length > 0 ? 0.05 : 0.01);
      EXPECT_NEAR(variation, 0.2, correlation_length > 0 ? 0.03 : 0.005);
      EXPECT_NEAR(with_strength, largest * shared, 0.08);
    }
}

TEST(StiffnessVariation, DependsOnTheTetrahedronNotOnThePart) {
  const auto mesh = test::make_box({.size = {0.01, 0.02, 0.04}, .cells = {5, 10, 20}, .disturbance = 0.2});
  for (const double correlation_length : {0.0, 1e-3}) {
    input::Parameters parameters;
    parameters.materials[0].variation = {
        .distribution = Distribution::weibull, .modulus = 10, .correlation_length = correlation_length};
    const auto all = stiffness_factors(parameters, 0, 3, {mesh.nodes, mesh.tetrahedra});
    const auto parts = geometry::split(mesh, geometry::partition(mesh, 3));
    for (const auto& part : parts) {
      const auto own = stiffness_factors(parameters, 0, 3, span_of(part));
      for (std::size_t t = 0; t < own.size(); ++t)
        ASSERT_EQ(own[t], all[static_cast<std::size_t>(part.tetrahedron_number[t])]);
    }
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::fracture
