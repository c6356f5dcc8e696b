// SPDX-License-Identifier: GPL-3.0-or-later
// Bars of Weibull material under uniform tension: the load at the first break has the Weibull distribution
// for the bar's volume, for any mesh, and the modulus is recovered from it and from the size effect.
#include "dynamics/sample_run.h"

#include "support/box_mesh.h"
#include "support/distributions.h"
#include "support/effort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

constexpr double strength = 35e6;          // [Pa]
constexpr double reference_volume = 1e-9;  // [m^3]
constexpr double width = 1e-3;             // [m]

struct Bars {
  std::vector<double> first_break, fracture;  // stresses [Pa]
  double scale;                               // predicted by Weibull's law for the first break [Pa]
};

/// @param cells over the width of a bar
Bars pull_bars(double modulus, double length, int cells, int n_samples, double correlation_length = 0) {
  input::Parameters parameters;
  parameters.materials[0] = test::epoxy();
  parameters.fracture = {.strength = strength, .exponent = 2, .impulse = 1e4};
  parameters.fracture.variation = input::Variation{.distribution = input::Distribution::weibull,
                                                   .modulus = modulus,
                                                   .reference_volume = reference_volume,
                                                   .correlation_length = correlation_length};
  parameters.specimen.size = {width, width, length};
  parameters.time.duration = 1e-7;
  parameters.time.integrator = input::Integrator::verlet;
  parameters.output.frames = 0;
  parameters.boundaries = test::uniform_pull();
  const auto mesh =
      test::make_box({.size = parameters.specimen.size,
                      .cells = {cells, cells, static_cast<int>(std::lround(cells * length / width))},
                      .disturbance = 0.1});
  const auto subdomain = test::whole(mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  Bars bars;
  for (int sample = 0; sample < n_samples; ++sample) {
    SampleControl control;
    control.sample = static_cast<std::uint64_t>(sample);
    const auto result = run_sample(self, parameters, parameters.output, subdomain, control);
    bars.first_break.push_back(result.first_break_load / (width * width));
    double largest_load = 0;  // [N], at 1 N/s
    for (const auto& record : result.breaks) largest_load = std::max(largest_load, record.load_time);
    bars.fracture.push_back(largest_load / (width * width));
  }
  bars.scale = correlation_length > 0
                   ? strength
                   : strength * std::pow(reference_volume / (width * width * length), 1 / modulus);
  return bars;
}

double distance_from_law(const std::vector<double>& stresses, double modulus, double scale) {
  return test::kolmogorov_distance(
      stresses, [&](double stress) { return 1 - std::exp(-std::pow(stress / scale, modulus)); });
}

void print(const char* what, const std::vector<double>& stresses, double modulus, double scale) {
  const auto fit = test::fit_weibull(stresses);
  std::printf(
      "%s: distance from Weibull's law %.3f (99.9 %%: %.3f), modulus %.2f +- %.2f, scale %.2f MPa, expected "
      "%.2f\n",
      what, distance_from_law(stresses, modulus, scale), test::kolmogorov_limit(stresses.size()), fit.modulus,
      fit.standard_error, fit.scale / 1e6, scale / 1e6);
}

TEST(WeibullBars, BreakAtTheLoadsOfTheirVolume) {
  const int n = test::repetitions(150, 1000);
  constexpr double modulus = 8;
  const std::array lengths{1e-3, 2e-3, 4e-3};
  std::array<test::WeibullFit, 3> fits{};
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const Bars bars = pull_bars(modulus, lengths[i], 2, n);
    std::printf("%d bars of %.0f mm^3:\n", n, width * width * lengths[i] * 1e9);
    print("  first break", bars.first_break, modulus, bars.scale);
    print("  fracture", bars.fracture, modulus, bars.scale);
    fits[i] = test::fit_weibull(bars.first_break);
    EXPECT_LT(distance_from_law(bars.first_break, modulus, bars.scale), test::kolmogorov_limit(n));
    EXPECT_NEAR(fits[i].modulus, modulus, 3 * fits[i].standard_error);
  }
  // The scale falls as volume^(-1/modulus); the standard error of its logarithm is 1.05 / (modulus sqrt(n)).
  const double slope = std::log(fits[0].scale / fits[2].scale) / std::log(lengths[2] / lengths[0]);
  const double standard_error = std::sqrt(2.0) * 1.05 / (modulus * std::sqrt(n)) / std::log(4.0);
  std::printf("scale over volume: exponent %.4f +- %.4f, expected %.4f, so a modulus of %.1f\n", -slope,
              standard_error, -1 / modulus, 1 / slope);
  EXPECT_NEAR(slope, 1 / modulus, 3 * standard_error);
}

TEST(WeibullBars, BreakAtTheSameLoadsOnAnotherMesh) {
  const int n = test::repetitions(50, 250);
  constexpr double modulus = 8;
  const Bars fine = pull_bars(modulus, 1e-3, 4, n);
  std::printf("8 times as many tetrahedra in 1 mm^3:\n");
  print("  first break", fine.first_break, modulus, fine.scale);
  print("  fracture", fine.fracture, modulus, fine.scale);
  EXPECT_LT(distance_from_law(fine.first_break, modulus, fine.scale), test::kolmogorov_limit(n));
}

TEST(WeibullBars, FailAtTheLoadsOfTheLawWhereNeighboursDifferLittle) {
  const int n = test::repetitions(150, 1000);
  const auto check = [n](const char* name, double modulus, double correlation_length) {
    const Bars bars = pull_bars(modulus, 1e-3, 2, n, correlation_length);
    print(name, bars.fracture, modulus, bars.scale);
    EXPECT_LT(distance_from_law(bars.fracture, modulus, bars.scale), test::kolmogorov_limit(n));
  };
  check("modulus 50, fracture", 50, 0);
  check("modulus 8, correlation length 50 mm, fracture", 8, 0.05);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
