// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/random.h"
#include "fracture/breakable_body.h"
#include "fracture/equivalent_stress.h"
#include "fracture/tuler_butcher.h"

#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <vector>

namespace crackle::fracture {
namespace CRACKLE_TEST_FILE {

input::Fracture epoxy_fracture(input::Accumulation accumulation = input::Accumulation::cumulative) {
  return {.strength = 35e6, .exponent = 2, .impulse = 1e4, .accumulation = accumulation};  // 1e-8 MPa^2 s
}

std::unique_ptr<Criterion> criterion_of(const input::Fracture& fracture, std::vector<double> strengths,
                                        double time_step) {
  return make_criterion(fracture, std::move(strengths), time_step,
                        mechanics::TetrahedronField(fracture.impulse));
}

std::unique_ptr<Criterion> one_tetrahedron(
    double time_step, input::Accumulation accumulation = input::Accumulation::cumulative) {
  return criterion_of(epoxy_fracture(accumulation), {35e6}, time_step);
}

/// Time at which the tetrahedron breaks under stress(t), in steps from `start` on.
double breaking_time(std::unique_ptr<Criterion> criterion, auto&& stress, double dt, int max_steps,
                     double start = 0) {
  for (int step = 1; step <= max_steps; ++step) {
    const double time = start + step * dt;
    if (criterion->advance(0, stress(time - 2 * dt), stress(time - dt), stress(time))) return time;
  }
  return INFINITY;
}

TEST(TulerButcher, ConstantOverstressFailsAfterItsImpulse) {
  for (const double over : {0.5e6, 1e6, 3e6}) {
    const double expected = 1e4 / (over * over);
    const double dt = expected / 1000;
    const double time = breaking_time(
        one_tetrahedron(dt), [&](double) { return 35e6 + over; }, dt, 2000);
    std::printf("overstress %.1f MPa: %.4g ns, exact %.4g ns\n", over * 1e-6, time * 1e9, expected * 1e9);
    EXPECT_NEAR(time, expected, 1.01 * dt);
    EXPECT_DOUBLE_EQ(one_tetrahedron(dt)->time_to_failure(0, 35e6 + over), expected);
  }
}

TEST(TulerButcher, RampFailsAtTheCubeRoot) {
  const double rate = 1e6 / 1e-8;  // 1 MPa in 10 ns
  const double expected = std::cbrt(3 * 1e4 / (rate * rate));
  const double dt = expected / 2000;
  const double time = breaking_time(
      one_tetrahedron(dt), [&](double t) { return 35e6 + rate * t; }, dt, 4000);
  std::printf("ramp: %.5g ns, exact %.5g ns\n", time * 1e9, expected * 1e9);
  EXPECT_NEAR(time, expected, 2 * dt);
}

TEST(TulerButcher, IntegralOfAStressThatChangesInProportionToTimeIsExact) {
  // Up from below the threshold, down again at another rate, and up over a step that starts above it.
  const double up = 2e6 / 1e-8, down = 3e6 / 1e-8;
  const auto over = [&](double t) {
    const double top = up * 4e-8 - 1e6;
    return t < 4e-8 ? up * t - 1e6 : t < 7e-8 ? top - down * (t - 4e-8) : top - down * 3e-8 + up * (t - 7e-8);
  };
  for (const double exponent : {0.5, 1.0, 2.0, 2.5, 3.0}) {
    input::Fracture parameters = epoxy_fracture();
    parameters.exponent = exponent;
    parameters.impulse = 1e300;
    const auto part = [&](double from, double to, double rate) {  // of the integral, along one straight line
      const auto power = [&](double x) { return std::pow(std::max(x, 0.0), exponent + 1); };
      return (power(to) - power(from)) / (rate * (exponent + 1));
    };
    const double expected = part(over(0), over(4e-8), up) + part(over(4e-8), over(7e-8), -down) +
                            part(over(7e-8), over(12e-8), up);
    double worst = 0;
    for (const double dt : {1e-8, 5e-9, 1e-9, 1e-10}) {
      TulerButcher criterion(parameters, parameters.impulse, {parameters.strength}, dt);
      for (int step = 0; step < std::lround(12e-8 / dt); ++step)
        EXPECT_FALSE(criterion.advance(0, 35e6, 35e6 + over(step * dt), 35e6 + over((step + 1) * dt)));
      worst = std::max(worst, std::abs(criterion.memory()[0] / expected - 1));
    }
    std::printf("exponent %.1f: relative error of the integral with four steps at most %.1e\n", exponent,
                worst);
    EXPECT_LT(worst, 1e-12);
  }
}

TEST(TulerButcher, BreaksAtTheEndOfAStepNearestToTheMomentOfFailure) {
  // For a ramp that passes the threshold at time 0: with some of these steps it breaks before the first end
  // of a step above the threshold.
  const double rate = 1e6 / 1e-8;
  for (const double exponent : {1.0, 2.0, 3.0}) {
    input::Fracture parameters = epoxy_fracture();
    parameters.exponent = exponent;
    parameters.impulse = 1e4 * std::pow(1e6, exponent - 2);
    const double expected =
        std::pow((exponent + 1) * parameters.impulse / std::pow(rate, exponent), 1 / (exponent + 1));
    for (const double steps : {0.2, 0.7, 1.0, 1.9, 3.0, 11.0}) {
      const double dt = expected / steps;
      double worst = 0, mean = 0;
      const int n_phases = 50;
      for (int phase = 0; phase < n_phases; ++phase) {
        const double start = -10 * dt + (phase + 0.5) / n_phases * dt;
        const double time = breaking_time(
            criterion_of(parameters, {parameters.strength}, dt), [&](double t) { return 35e6 + rate * t; },
            dt, 100, start);
        worst = std::max(worst, std::abs(time - expected) / dt);
        mean += (time - expected) / dt / n_phases;
      }
      EXPECT_LE(worst, 0.5 + 1e-6) << "exponent " << exponent << ", " << steps << " steps to failure";
      EXPECT_NEAR(mean, 0, 1e-6) << "exponent " << exponent << ", " << steps << " steps to failure";
    }
  }
}

TEST(TulerButcher, WatchesWhatMayBreakWithinHalfAStep) {
  const auto share = [](double step, input::Accumulation accumulation = input::Accumulation::cumulative) {
    return one_tetrahedron(step, accumulation)->screening_share(5e-8);
  };
  EXPECT_LT(share(4.5e-8), 0.85);
  EXPECT_GT(share(4.5e-8), 0.75);
  EXPECT_GT(share(5e-9), 0.97) << "small steps need no more than the strength";
  EXPECT_EQ(share(4.5e-8, input::Accumulation::step), 1) << "the last step counts only where it ends";
}

TEST(TulerButcher, NeverFailsBelowTheThreshold) {
  EXPECT_EQ(breaking_time(
                one_tetrahedron(1), [](double) { return 35e6; }, 1.0, 100000),
            INFINITY);
  EXPECT_EQ(one_tetrahedron(1)->time_to_failure(0, 35e6), INFINITY);
}

TEST(TulerButcher, StepMemoryIsAStrengthThatFollowsFromTheStep) {
  const double dt = 5e-9;
  const double needed = std::sqrt(1e4 / dt);
  const auto criterion = one_tetrahedron(dt, input::Accumulation::step);
  std::printf("strength %.4f MPa\n", 1e-6 * criterion->strength(0));
  EXPECT_NEAR(criterion->strength(0), 36.41e6, 0.01e6);  // 1.41 MPa above the threshold
  const auto run = [&](double over) {
    return breaking_time(
        one_tetrahedron(dt, input::Accumulation::step), [&](double) { return 35e6 + over; }, dt, 10000);
  };
  EXPECT_EQ(run(0.999 * needed), INFINITY);
  EXPECT_EQ(run(1.001 * needed), dt);
  EXPECT_EQ(criterion->time_to_failure(0, 35e6 + 0.999 * needed), INFINITY);
  EXPECT_EQ(criterion->time_to_failure(0, 35e6 + 1.001 * needed), dt);
}

TEST(TulerButcher, StepMemoryAddsToTheStrengthOfEachTetrahedron) {
  auto parameters = epoxy_fracture(input::Accumulation::step);
  parameters.exponent = 1;
  parameters.impulse = 0.01;
  const std::vector<double> strengths{30e6, 40e6};
  const auto criterion = criterion_of(parameters, strengths, 5e-9);
  EXPECT_DOUBLE_EQ(criterion->strength(0), 32e6);
  EXPECT_DOUBLE_EQ(criterion->strength(1), 42e6);
  parameters.toughness = 3;
  EXPECT_EQ(criterion_of(parameters, strengths, 5e-9)->strength(1), 40e6)
      << "what a slow crack takes is given";
}

TEST(TulerButcher, CumulativeMemoryKeepsEarlierImpulse) {
  // Above the threshold for half the impulse, below it for a long time, then above it for the other half.
  const double half = 0.5 * 1e4 / 1e12;
  const double dt = half / 500;
  const auto stress = [&](double t) { return t <= half || t > 10 * half ? 36e6 : 20e6; };
  EXPECT_NEAR(breaking_time(one_tetrahedron(dt), stress, dt, 20000), 11 * half, 2 * dt);
}

TEST(PrincipalStress, MatchesTensorsOfKnownValues) {
  EXPECT_DOUBLE_EQ(largest_principal({1, 5, 3, 0, 0, 0}), 5);
  EXPECT_NEAR(largest_principal({0, 0, 0, 2, 0, 0}), 2, 1e-15);
  EXPECT_NEAR(largest_principal({3, 3, 1, 0, 0, 0}), 3, 1e-15);
  EXPECT_NEAR(largest_principal({-1, -1, -1, 0, 0, 0}), -1, 1e-15);
  RandomStream stream(4, 0, "stress");
  double worst = 0;
  for (int i = 0; i < 1000; ++i) {
    mechanics::Symmetric s{};
    for (auto& value : s) value = stream.uniform(-1, 1);
    const double value = largest_principal(s);
    // The characteristic polynomial vanishes at a principal value.
    const double a = s[0] - value, b = s[1] - value, c = s[2] - value;
    const double determinant =
        a * (b * c - s[3] * s[3]) - s[5] * (s[5] * c - s[3] * s[4]) + s[4] * (s[5] * s[3] - b * s[4]);
    worst = std::max(worst, std::abs(determinant));
    EXPECT_GE(LargestPrincipalStress().bound(s), value - 1e-14);
    EXPECT_EQ(LargestPrincipalStress().side(s, value + 1e-9), -1);
    EXPECT_EQ(LargestPrincipalStress().side(s, value - 1e-9), 1);
    EXPECT_EQ(LargestPrincipalStress().side(s, value), 0);
  }
  // Three equal values, and two.
  for (const mechanics::Symmetric& s : {mechanics::Symmetric{2, 2, 2, 0, 0, 0}, {2, 2, 1, 0, 0, 0}}) {
    EXPECT_EQ(LargestPrincipalStress().side(s, 2), 0);
    EXPECT_EQ(LargestPrincipalStress().side(s, 2.001), -1);
    EXPECT_EQ(LargestPrincipalStress().side(s, 1.999), 1);
  }
  std::printf("largest determinant at a principal value: %.2e\n", worst);
  EXPECT_LT(worst, 1e-13);
}

TEST(Cuts, UniaxialTensionOpensTheFacetsAcrossIt) {
  // A corner tetrahedron: cut 3 separates the node on the z axis; its vector area points along z.
  const auto t =
      mechanics::tetrahedron_operator({0, 1, 2, 3}, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});
  const auto areas = cut_areas(t);
  EXPECT_NEAR(areas[3][2], 1.0 / 6, 1e-15);
  EXPECT_EQ(most_loaded_cut(t, {0, 0, 1, 0, 0, 0}), 3);
  EXPECT_EQ(most_loaded_cut(t, {1, 0, 0, 0, 0, 0}), 1);
  // The areas of complementary cuts: V (b^0 + b^3) separates the pairs {0,3} and {1,2}.
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(areas[6][i], areas[0][i] + areas[3][i], 1e-15);
}

TEST(BreakableBody, RecordsEnergyAndStressOfABreak) {
  const auto mesh = test::make_box({.cells = {1, 1, 1}});
  const auto subdomain = test::whole(mesh);
  BreakableBody body(subdomain, test::epoxy());
  std::vector<double> u;
  for (const auto& p : subdomain.nodes) u.insert(u.end(), {-0.38e-3 * p[0], -0.38e-3 * p[1], 1e-3 * p[2]});
  body.release(2, body.strain(2, u), 1.5, 2e-6);
  ASSERT_EQ(body.breaks().size(), 1U);
  const Break& record = body.breaks()[0];
  EXPECT_NEAR(record.principal_stress, 3.3e6, 1e-6);
  EXPECT_NEAR(record.released_energy, 0.5 * 3.3e6 * 1e-3 / 6, 1e-9);
  EXPECT_EQ(record.tetrahedron, 2);
  EXPECT_TRUE(body.is_broken(2));
  double strain_energy = 0;
  for (const double e : body.strain_energies(u)) strain_energy += e;
  EXPECT_NEAR(strain_energy + record.released_energy, 0.5 * 3.3e6 * 1e-3, 1e-8);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::fracture
