// SPDX-License-Identifier: GPL-3.0-or-later
// Random inputs: distributions against their closed forms, sampling plans, draws and the resulting inputs.
#include "input/reader.h"
#include "uncertainty/polynomials.h"
#include "uncertainty/random_inputs.h"

#include "input_samples.h"
#include "support/distributions.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <boost/math/distributions/beta.hpp>
#include <boost/math/distributions/lognormal.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/special_functions/jacobi.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <initializer_list>
#include <set>

namespace crackle::uncertainty {
namespace CRACKLE_TEST_FILE {

using ::testing::HasSubstr;

/// The minimal input with random Young's modulus and strength.
std::string uncertain(const std::string& plan, int samples, int replicates = 1) {
  auto tables = test::minimal_tables();
  test::set_key(tables, "[ensemble]", "samples", std::to_string(samples));
  test::set_key(tables, "[ensemble]", "plan", '"' + plan + '"');
  test::set_key(tables, "[ensemble]", "replicates", std::to_string(replicates));
  return test::to_text(tables) + R"(
[[random]]
key = "material.youngs_modulus"
distribution = "normal"
standard_deviation = "165 MPa"
[[random]]
key = "fracture.strength"
distribution = "uniform"
lower = "30 MPa"
upper = "40 MPa"
)";
}

input::Parameters parse(const std::string& text) {
  return input::parse(text, "plate.toml");
}

TEST(RandomInputs, QuantilesHaveTheirClosedForms) {
  using input::RandomDistribution;
  const input::RandomInput normal{
      .distribution = RandomDistribution::normal, .mean = 3, .standard_deviation = 2};
  const auto with = [&](auto change) {
    input::RandomInput random = normal;
    change(random);
    return random;
  };
  const boost::math::normal standard;
  const auto z = [&](double p) { return boost::math::quantile(standard, p); };
  const auto share = [&](double x) { return boost::math::cdf(standard, x); };
  struct Case {
    const char* name;
    input::RandomInput random;
    std::function<double(double)> expected;
  };
  const double log_variance = std::log(1 + 4.0 / 9);
  const std::vector<Case> cases{
      {"normal", normal, [&](double p) { return 3 + 2 * z(p); }},
      {"lognormal", with([](auto& r) { r.distribution = RandomDistribution::lognormal; }),
       [&](double p) { return 3 * std::exp(-log_variance / 2 + std::sqrt(log_variance) * z(p)); }},
      {"lognormal from 1 on", with([](auto& r) {
         r.distribution = RandomDistribution::lognormal;
         r.lower = 1;
       }),
       [&](double p) {
         const double s = std::log(1 + 4.0 / 4);
         return 1 + 2 * std::exp(-s / 2 + std::sqrt(s) * z(p));
       }},
      {"uniform", with([](auto& r) {
         r.distribution = RandomDistribution::uniform;
         r.lower = -1;
         r.upper = 4;
       }),
       [](double p) { return -1 + 5 * p; }},
      {"triangular with a mode", with([](auto& r) {
         r.distribution = RandomDistribution::triangular;
         r.mean = not_a_number;
         r.lower = 0, r.mode = 1, r.upper = 4;
       }),
       [](double p) { return p < 0.25 ? std::sqrt(4 * p) : 4 - std::sqrt(12 * (1 - p)); }},
      {"triangular with a mean", with([](auto& r) {
         r.distribution = RandomDistribution::triangular;
         r.lower = 0, r.mean = 5.0 / 3, r.upper = 4;
       }),
       [](double p) { return p < 0.25 ? std::sqrt(4 * p) : 4 - std::sqrt(12 * (1 - p)); }},
      {"weibull", with([](auto& r) {
         r.distribution = RandomDistribution::weibull;
         r.scale = 36, r.shape = 20, r.lower = 2;
       }),
       [](double p) { return 2 + 36 * std::pow(-std::log1p(-p), 1.0 / 20); }},
      {"beta", with([](auto& r) {
         r.distribution = RandomDistribution::beta;
         r.lower = 1, r.upper = 6, r.standard_deviation = 1;
       }),
       [](double p) {
         const double m = 2.0 / 5, v = 1.0 / 25, sum = m * (1 - m) / v - 1;
         return 1 + 5 * boost::math::quantile(boost::math::beta_distribution<>(m * sum, (1 - m) * sum), p);
       }},
      {"truncated", with([](auto& r) {
         r.distribution = RandomDistribution::truncated;
         r.lower = 2, r.upper = 4;
       }),
       [&](double p) { return 3 + 2 * z(share(-0.5) + p * (share(0.5) - share(-0.5))); }},
      {"truncated below", with([](auto& r) {
         r.distribution = RandomDistribution::truncated;
         r.lower = 2;
       }),
       [&](double p) { return 3 + 2 * z(share(-0.5) + p * (1 - share(-0.5))); }}};
  double worst = 0;
  for (const Case& one : cases) {
    for (const double p : {1e-9, 1e-3, 0.1, 0.25, 0.5, 0.8, 0.999}) {
      const double value = quantile(one.random, p), expected = one.expected(p);
      EXPECT_NEAR(value, expected, 1e-8 * std::max(1.0, std::abs(expected))) << one.name << " at " << p;
      worst = std::max(worst, std::abs(value - expected) / std::max(1.0, std::abs(expected)));
    }
  }
  std::printf("quantiles of %zu distributions off by %.1e at most\n", cases.size(), worst);
}

/// The first points of scipy.stats.qmc.Sobol(d, scramble=False), in binary digits, in dimensions 0, 2 and 7:
/// after the random shift is taken back.
TEST(RandomInputs, SobolPointsAreThoseOfJoeAndKuo) {
  const auto bits = [](std::uint64_t number, std::size_t k) {
    return static_cast<std::uint64_t>(
        std::ldexp(plan_point(input::SamplingPlan::sobol, 5, 0, 8, number)[k], 53));
  };
  const std::vector<std::array<double, 3>> expected{
      {0, 0, 0}, {0.5, 0.5, 0.5}, {0.75, 0.25, 0.75}, {0.25, 0.75, 0.25}, {0.375, 0.625, 0.875}};
  for (std::uint64_t number = 0; number < expected.size(); ++number)
    for (const std::size_t k : {0, 1, 2}) {
      const std::size_t dimension = std::array{0, 2, 7}[k];
      const std::uint64_t unshifted = bits(number, dimension) ^ bits(0, dimension);
      EXPECT_NEAR(std::ldexp(static_cast<double>(unshifted), -53), expected[number][k], 1e-14)
          << "point " << number << ", dimension " << dimension;
    }
}

/// The mean of a polynomial of a triangular variable is exact by Gauss's rule on both sides of the mode;
/// those of a beta variable are Jacobi's.
TEST(RandomInputs, PolynomialsAreOrthonormal) {
  using input::RandomDistribution;
  constexpr int highest = 8;
  input::RandomInput triangular{.distribution = RandomDistribution::triangular};
  triangular.lower = 2, triangular.mode = 3, triangular.upper = 7;
  const auto mean_of_product = [&](std::size_t i, std::size_t j) {
    const auto weighted = [&](double x) {
      const auto p = orthonormal_polynomials(triangular, std::vector{x}, highest);
      const double density = x < 3 ? (x - 2) / 1 * 0.4 : (7 - x) / 4 * 0.4;
      return p[i][0] * p[j][0] * density;
    };
    boost::math::quadrature::gauss<double, 15> rule;
    return rule.integrate(weighted, 2.0, 3.0) + rule.integrate(weighted, 3.0, 7.0);
  };
  double worst = 0;
  for (std::size_t i = 0; i <= highest; i += 2)
    for (std::size_t j = 0; j <= i; ++j)
      worst = std::max(worst, std::abs(mean_of_product(i, j) - (i == j ? 1 : 0)));
  std::printf("triangular: products off by %.1e at most\n", worst);
  EXPECT_LT(worst, 1e-8);

  // On (-1, 1), of the shapes 2 and 3.5: mean 2 (2 / 5.5) - 1.
  const double a = 2, b = 3.5;
  input::RandomInput beta{.distribution = RandomDistribution::beta};
  beta.lower = -1, beta.upper = 1, beta.mean = 2 * a / (a + b) - 1;
  beta.standard_deviation = 2 * std::sqrt(a * b / (a + b + 1)) / (a + b);
  const std::vector<double> values{-0.95, -0.5, 0.1, 0.8};
  const auto found = orthonormal_polynomials(beta, values, highest);
  double furthest = 0;
  for (unsigned n = 1; n <= highest; ++n)
    for (std::size_t i = 0; i < values.size(); ++i) {
      // Jacobi's have the weight (1 - x)^(b - 1) (1 + x)^(a - 1); the constant follows from their norms.
      const double p = b - 1, q = a - 1, m = n;
      const double norm =
          std::exp(std::lgamma(m + p + 1) + std::lgamma(m + q + 1) - std::lgamma(m + p + q + 1) -
                   std::lgamma(m + 1) + std::lgamma(p + q + 2) - std::lgamma(p + 1) - std::lgamma(q + 1)) /
          (2 * m + p + q + 1);
      const double expected = boost::math::jacobi(n, p, q, values[i]) / std::sqrt(norm);
      furthest = std::max(furthest, std::abs(found[n][i] - expected) / std::max(1.0, std::abs(expected)));
    }
  std::printf("beta: off Jacobi's polynomials by %.1e at most\n", furthest);
  EXPECT_LT(furthest, 1e-8);
}

TEST(RandomInputs, ALatinHypercubeHasOnePointInEachLayer) {
  constexpr std::uint64_t n = 50;
  for (std::size_t k = 0; k < 3; ++k) {
    std::set<int> layers;
    for (std::uint64_t i = 0; i < n; ++i)
      layers.insert(static_cast<int>(plan_point(input::SamplingPlan::latin_hypercube, 3, n, 3, i)[k] * n));
    EXPECT_EQ(layers.size(), n) << "dimension " << k;
  }
  EXPECT_THROW(plan_point(input::SamplingPlan::latin_hypercube, 3, n, 3, n), std::runtime_error);
}

TEST(RandomInputs, SobolPointsFillTheBoxesOfANet) {
  // 64 points in two dimensions: one in each box of 1/64 of the area, for any aspect ratio (a (0, 6, 2)-net),
  // also under the random shift.
  for (const int columns : {1, 2, 8, 32, 64}) {
    std::set<int> boxes;
    for (std::uint64_t i = 0; i < 64; ++i) {
      const auto p = plan_point(input::SamplingPlan::sobol, 5, 0, 2, i);
      const int rows = 64 / columns;
      boxes.insert(static_cast<int>(p[0] * columns) * rows + static_cast<int>(p[1] * rows));
    }
    EXPECT_EQ(boxes.size(), 64u) << columns;
  }
}

TEST(RandomInputs, DrawsOfASobolPlanFillAllStrataOfEachInput) {
  for (const int seed : {0, 2012}) {
    auto parameters = parse(uncertain("sobol", 128));
    parameters.seed = static_cast<std::uint64_t>(seed);
    std::set<int> of_modulus, of_strength;
    for (std::uint64_t sample = 0; sample < 128; ++sample) {
      const auto values = drawn_values(parameters, sample);
      const boost::math::normal modulus(parameters.materials[0].youngs_modulus, 165e6);
      of_modulus.insert(static_cast<int>(128 * boost::math::cdf(modulus, values[0])));
      of_strength.insert(static_cast<int>(128 * (values[1] - 30e6) / 10e6));
    }
    EXPECT_EQ(of_modulus.size(), 128u) << "seed " << seed;
    EXPECT_EQ(of_strength.size(), 128u) << "seed " << seed;
  }
}

TEST(RandomInputs, PointsOfAllPlansAreUniformAndDifferBySeed) {
  using enum input::SamplingPlan;
  for (const auto plan : {independent, latin_hypercube, sobol}) {
    std::vector<double> first;
    double difference = 0;
    for (std::uint64_t i = 0; i < 400; ++i) {
      const auto point = plan_point(plan, 1, 400, 2, i);
      first.push_back(point[0]);
      difference = std::max(difference, std::abs(point[0] - plan_point(plan, 2, 400, 2, i)[0]));
      EXPECT_EQ(point, plan_point(plan, 1, 400, 2, i)) << "the same again";
    }
    EXPECT_LT(test::kolmogorov_distance(first, [](double u) { return u; }), test::kolmogorov_limit(400));
    EXPECT_GT(difference, 0.1);
  }
}

TEST(RandomInputs, ADrawIsAnInputWithOtherValues) {
  const auto parameters = parse(uncertain("sobol", 6, 2));
  const auto values = drawn_values(parameters, 2);
  ASSERT_EQ(values.size(), 2u);
  EXPECT_EQ(values, drawn_values(parameters, 3)) << "a replicate";
  EXPECT_NE(values, drawn_values(parameters, 4));
  const auto drawn = sample_parameters(parameters, 3);
  EXPECT_EQ(drawn.materials[0].youngs_modulus, values[0]);
  EXPECT_EQ(drawn.fracture.strength, values[1]);
  EXPECT_EQ(drawn.materials[0].density, parameters.materials[0].density);
  EXPECT_EQ(drawn.text, parameters.text);
  EXPECT_EQ(sample_identity(drawn), sample_identity(parameters)) << "of the same ensemble";
  EXPECT_EQ(std::stod(fmt::format("{:.6g}", values[0])), values[0]) << "six digits";
}

/// The drawn value replaces the input's own, which is the default mean.
TEST(RandomInputs, ADrawNeedNotBeAMeanOfItsDistribution) {
  auto tables = test::minimal_tables();
  test::set_key(tables, "[material]", "youngs_modulus", "\"3300 MPa\"");
  for (const char* const distribution :
       {"\"beta\"\nlower = \"3000 MPa\"\nupper = \"3600 MPa\"\nstandard_deviation = \"200 MPa\"",
        "\"lognormal\"\nlower = \"3299.999 MPa\"\nstandard_deviation = \"200 MPa\""}) {
    const auto parameters = parse(test::to_text(tables) + "[[random]]\nkey = \"material.youngs_modulus\"\n" +
                                  "distribution = " + distribution + "\n");
    for (std::uint64_t sample = 0; sample < 200; ++sample)
      EXPECT_NO_THROW(sample_parameters(parameters, sample));
  }
}

TEST(RandomInputs, OnlyALatinHypercubeCannotBeExtended) {
  for (const char* const plan : {"independent", "sobol"}) {
    const auto few = parse(uncertain(plan, 8)), more = parse(uncertain(plan, 32));
    EXPECT_EQ(sample_identity(few), sample_identity(more)) << plan;
    for (std::uint64_t i = 0; i < 8; ++i) EXPECT_EQ(drawn_values(few, i), drawn_values(more, i)) << plan;
  }
  const auto few = parse(uncertain("latin-hypercube", 8)), more = parse(uncertain("latin-hypercube", 32));
  EXPECT_NE(sample_identity(few), sample_identity(more));
  EXPECT_NE(sample_identity(few), sample_identity(parse(uncertain("sobol", 8))));
}

TEST(RandomInputs, AnInputWithoutThemHasTheIdentityItHad) {
  EXPECT_THAT(input::echo(parse(test::to_text(test::minimal_tables()))),
              ::testing::Not(::testing::AnyOf(HasSubstr("replicates"), HasSubstr("ensemble.plan"))));
}

/// A roller is moved with both ends of its region, and stays a line.
TEST(RandomInputs, NumbersOfOneKeyChangeByTheSameAmount) {
  auto tables = test::minimal_tables();
  test::set_key(tables, "[mesh]", "base", "\"own\"");
  const std::string body = test::to_text(tables) + R"(
[[mesh.region]]
z = ["20 mm", "30 mm"]
spacing = "0.5 mm"
)";
  const auto with = [&](const std::string& keys) {
    return body + "[[random]]\nkey = " + keys +
           "\ndistribution = \"uniform\"\nlower = \"15 mm\"\nupper = \"25 mm\"\n";
  };
  const auto parameters = parse(with(R"(["mesh.region[0].z[0]", "mesh.region[0].z[1]"])"));
  EXPECT_THAT(input::keys_of(parameters.random.at(0)),
              ::testing::ElementsAre("mesh.region[0].z[0]", "mesh.region[0].z[1]"));
  EXPECT_THAT(input::describe(parameters.random[0]), HasSubstr("with mesh.region[0].z[1]"));
  std::set<double> places;
  for (std::uint64_t i = 0; i < 4; ++i) {
    const auto drawn = sample_parameters(parameters, i);
    const auto& [lower, upper] = drawn.mesh.regions.at(0).box[2];
    EXPECT_NEAR(upper - lower, 0.01, 1e-15);
    places.insert(lower);
  }
  EXPECT_EQ(places.size(), 4u);
  const auto message = [&](const std::string& keys) -> std::string {
    try {
      parse(with(keys));
    } catch (const input::InputError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_THAT(message(R"(["mesh.region[0].z[0]", "mesh.region[0].z[0]"])"), HasSubstr("is random already"));
  EXPECT_THAT(message(R"(["mesh.region[0].z[0]", "material.density"])"), HasSubstr("different units"));
  EXPECT_THAT(message(R"(["mesh.region[0].z[0]", "mesh.region[1].z[0]"])"), HasSubstr("does not give"));
  EXPECT_THAT(message("[]"), HasSubstr("0 elements"));
}

TEST(RandomInputs, NumbersOfOneKeyChangeByTheSameFactor) {
  const auto parameters = parse(test::to_text(test::minimal_tables()) + R"(
[[random]]
key = ["material.youngs_modulus", "fracture.strength", "material.density"]
together = "factor"
distribution = "uniform"
lower = "3000 MPa"
upper = "3600 MPa"
)");
  for (std::uint64_t i = 0; i < 4; ++i) {
    const auto drawn = sample_parameters(parameters, i);
    const double factor = drawn.material().youngs_modulus / parameters.material().youngs_modulus;
    EXPECT_NE(factor, 1);
    EXPECT_NEAR(drawn.fracture.strength, factor * parameters.fracture.strength, 1);
    EXPECT_NEAR(drawn.material().density, factor * parameters.material().density, 1e-9);
  }
  EXPECT_THAT(input::describe(parameters.random[0]), HasSubstr("with fracture.strength by the same factor"));
}

TEST(RandomInputs, SomeValuesOrMeasuredOnes) {
  const auto parameters = parse(test::to_text(test::minimal_tables()) + R"(
[[random]]
key = "material.youngs_modulus"
distribution = "discrete"
values = ["4 GPa", "3 GPa"]
weights = [1, 3]
[[random]]
key = "fracture.strength"
distribution = "empirical"
values = ["30 MPa", "36 MPa", "31 MPa"]
)");
  const auto& [discrete, empirical] = std::tie(parameters.random[0], parameters.random[1]);
  EXPECT_EQ(quantile(discrete, 0.74), 3e9);
  EXPECT_EQ(quantile(discrete, 0.76), 4e9);
  EXPECT_EQ(quantile(empirical, 0.5), 31e6);
  EXPECT_DOUBLE_EQ(quantile(empirical, 0.75), 33.5e6);
  EXPECT_EQ(most_degree(discrete), 1);
  // Orthonormal over the four draws that have the weights.
  const std::vector<double> values{3e9, 3e9, 3e9, 4e9};
  const auto table = orthonormal_polynomials(discrete, values, 2);
  double sum = 0, square = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    sum += table[1][i] / 4;
    square += table[1][i] * table[1][i] / 4;
    EXPECT_EQ(table[2][i], 0);
  }
  EXPECT_NEAR(sum, 0, 1e-12);
  EXPECT_NEAR(square, 1, 1e-12);
}

TEST(RandomInputs, CorrelatedOnesHaveTheirRankCorrelationAndDistributions) {
  for (const double rank : {-0.5, 0.8}) {
    const auto parameters = parse(
        uncertain("sobol", 1024) +
        fmt::format(
            "[[correlation]]\nbetween = [\"fracture.strength\", \"material.youngs_modulus\"]\nrank = {}\n",
            rank));
    std::vector<std::vector<double>> values(2);
    for (std::uint64_t i = 0; i < 1024; ++i) {
      const auto drawn = drawn_values(parameters, i);
      for (const std::size_t k : {0, 1}) values[k].push_back(drawn[k]);
    }
    const auto ranks = [](const std::vector<double>& of) {
      std::vector<double> found;
      for (const double value : of)
        found.push_back(
            static_cast<double>(std::ranges::count_if(of, [&](double other) { return other < value; })));
      return found;
    };
    const auto one = ranks(values[0]), other = ranks(values[1]);
    double square = 0;
    for (std::size_t i = 0; i < one.size(); ++i) square += std::pow(one[i] - other[i], 2);
    const double n = 1024, found = 1 - 6 * square / (n * (n * n - 1));
    std::printf("rank correlation %.3f of %.1f\n", found, rank);
    EXPECT_NEAR(found, rank, 0.03);
    const auto [least, most] = std::ranges::minmax(values[1]);
    EXPECT_TRUE(least >= 30e6 && least < 30.1e6 && most <= 40e6 && most > 39.9e6);
  }
}

/// Slots 6 mm deep and 2 mm high at these places, and a random input.
input::Parameters with_slots(std::initializer_list<const char*> places, const std::string& random) {
  auto tables = test::minimal_tables();
  test::set_key(tables, "[mesh]", "base", "\"own\"");
  std::string text = test::to_text(tables);
  for (const char* const place : places)
    text += fmt::format(
        "\n[[specimen.notch]]\nface = \"y-min\"\nat = \"{}\"\ndepth = \"6 mm\"\nheight = \"2 mm\"\n", place);
  return parse(text + "[[random]]\n" + random);
}

/// Why the draw of a sample is refused; empty if it is not.
std::string refusal(const input::Parameters& parameters, std::uint64_t sample) {
  try {
    sample_parameters(parameters, sample);
    return {};
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

TEST(RandomInputs, ValuesThatMakeNoBodyAreRefusedWithTheirReason) {
  const std::string reason = refusal(with_slots({"60 mm"}, R"(key = "specimen.notch[0].depth"
distribution = "uniform"
lower = "25 mm"
upper = "26 mm"
)"),
                                     0);
  EXPECT_THAT(reason, HasSubstr("the drawn values do not give a valid input (specimen.notch[0].depth = 25."));
  EXPECT_THAT(reason, HasSubstr("24.5 mm"));
  EXPECT_THAT(reason, ::testing::Not(HasSubstr("\n")));
}

/// Slots that meet in some samples only would start other cracks there than the ensemble's statistics have.
TEST(RandomInputs, SlotsMeetInAllSamplesOrInNone) {
  const auto parameters = with_slots({"60 mm", "66 mm"}, R"(key = "specimen.notch[1].at"
distribution = "discrete"
values = ["61.5 mm", "66 mm"]
)");
  int n_refused = 0;
  for (std::uint64_t sample = 0; sample < 8; ++sample)
    if (const std::string reason = refusal(parameters, sample); !reason.empty()) {
      ++n_refused;
      EXPECT_THAT(reason, HasSubstr("slots meet here, but not with the values of the input"));
    }
  EXPECT_GT(n_refused, 0);
  EXPECT_LT(n_refused, 8);
}

TEST(RandomInputs, SharesAndAnglesCanVary) {
  auto tables = test::minimal_tables();
  test::set_key(tables, "[mesh]", "base", "\"own\"");
  test::set_key(tables, "[time]", "mass_scaling", "\"0.2 %\"");
  const auto parameters = parse(test::to_text(tables) + R"(
[[specimen.hole]]
center = ["12 mm", "60 mm"]
semi_axes = ["3 mm", "2 mm"]
angle = "30 degree"
[[random]]
key = "time.mass_scaling"
distribution = "uniform"
lower = "0.1 %"
upper = "0.3 %"
[[random]]
key = "specimen.hole[0].angle"
distribution = "uniform"
lower = "10 degree"
upper = "50 degree"
)");
  const auto own = sample_parameters(parameters, 1);
  const auto values = drawn_values(parameters, 1);
  EXPECT_EQ(own.time.mass_scaling, values.at(0));
  EXPECT_NEAR(own.specimen.holes.at(0).angle, values.at(1), 1e-15);
  EXPECT_GT(values[1], 10 * std::numbers::pi / 180);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::uncertainty
