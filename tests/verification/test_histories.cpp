// SPDX-License-Identifier: GPL-3.0-or-later
// Histories and probes against exact solutions: a bar in equilibrium, and waves in it.
#include "common/index.h"
#include "dynamics/sample_run.h"

#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

constexpr double length = 0.04, width = 0.004, thickness = 0.002;

/// A laterally constrained bar with one-dimensional waves.
class HistoryOfABar : public testing::Test {
protected:
  HistoryOfABar() {
    parameters.materials[0].poisson_ratio = 0;
    parameters.time.duration = 3e-5;
    parameters.output.probes = {{"first", {0.0011, 0.0017, 0.012}}, {"second", {0.0004, 0.0031, 0.028}}};
  }

  void add(Face face, BoundaryKind kind, std::array<bool, 3> components, double value, double rate) {
    parameters.boundaries.push_back(test::boundary(face, kind, components, {0, 0, value}, {0, 0, rate}));
  }

  SampleResult run() {
    mesh = test::make_box({.size = parameters.specimen.size, .cells = {2, 4, n_cells}, .disturbance = 0.2});
    return run_sample(parallel::Communicator(MPI_COMM_SELF), parameters, parameters.output,
                      test::whole(mesh));
  }

  input::Parameters parameters = test::brittle({thickness, width, length});
  geometry::Realization mesh;
  int n_cells = 80;
};

TEST_F(HistoryOfABar, InEquilibriumIsTheExactOne) {
  add(Face::z_min, BoundaryKind::fix, {true, true, true}, 0, 0);
  add(Face::z_max, BoundaryKind::displacement, {false, false, true}, 0, 1e-6);
  const SampleResult result = run();
  const auto& rows = result.history;
  ASSERT_GE(rows.size(), 3U);
  EXPECT_EQ(rows[0].phase, 0);
  EXPECT_EQ(rows[0].load, 0);
  const HistoryRow& onset = rows[1];
  EXPECT_EQ(onset.phase, 0);
  EXPECT_EQ(onset.energy.broken, 0);
  const double strain = onset.load_time * 1e-6 / length;
  const double stress = strain * parameters.materials[0].youngs_modulus;
  const double force = stress * width * thickness;
  std::printf("load %.9g N, exact %.9g N; work %.9g J, exact %.9g J; probe %.9g Pa, exact %.9g Pa\n",
              onset.load, force, onset.energy.external, 0.5 * force * strain * length,
              onset.probes[0].stress[2], stress);
  EXPECT_NEAR(stress, 35e6, 1e-3 * 35e6);
  EXPECT_NEAR(onset.load, force, 1e-8 * force);
  EXPECT_NEAR(onset.load_displacement, strain * length, 1e-12 * strain * length);
  EXPECT_NEAR(onset.force[0][2], -force, 1e-7 * force) << "the reaction below";
  EXPECT_NEAR(onset.force[1][2], force, 1e-7 * force);
  EXPECT_EQ(onset.displacement[0], Vector{});
  EXPECT_NEAR(onset.displacement[1][2], strain * length, 1e-8 * strain * length);
  EXPECT_NEAR(onset.energy.external, 0.5 * force * strain * length, 1e-8 * onset.energy.external);
  EXPECT_NEAR(onset.energy.strain, onset.energy.external, 1e-8 * onset.energy.external);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(onset.probes[i].displacement[2], strain * parameters.output.probes[i].at[2],
                1e-7 * strain * length);
    EXPECT_NEAR(onset.probes[i].stress[2], stress, 1e-6 * stress);
    EXPECT_EQ(onset.probes[i].velocity, Vector{});
  }
  EXPECT_EQ(rows[2].phase, 1) << "the dynamic phase follows";
  EXPECT_NEAR(rows[2].load, force, 1e-2 * force) << "after a first break";
  EXPECT_EQ(rows.back().energy, result.energy.back());
}

TEST_F(HistoryOfABar, FollowsAWave) {
  // Pulled with constant acceleration at one end: v = a (t - (L - z) / c), stress = rho c v.
  parameters.time.start = input::Start::rest;
  parameters.output.history = 5e-7;
  const double acceleration = 1e5;
  add(Face::z_max, BoundaryKind::velocity, {true, true, true}, 0, acceleration);
  const SampleResult result = run();
  EXPECT_TRUE(result.breaks.empty());
  const double density = parameters.materials[0].density;
  const double c = std::sqrt(parameters.materials[0].youngs_modulus / density);
  const double largest = acceleration * parameters.time.duration;
  double worst_velocity = 0, worst_stress = 0, worst_displacement = 0, worst_reaction = 0;
  double previous = -1;
  for (const HistoryRow& row : result.history) {
    const double t = row.energy.time;
    EXPECT_EQ(row.phase, 1);
    EXPECT_GT(t, previous);
    previous = t;
    // Until then nothing has returned from the free end.
    if (t > length / c) break;
    for (std::size_t i = 0; i < 2; ++i) {
      const double since = std::max(0.0, t - (length - parameters.output.probes[i].at[2]) / c);
      const auto& probe = row.probes[i];
      worst_velocity = std::max(worst_velocity, std::abs(probe.velocity[2] - acceleration * since) / largest);
      worst_displacement =
          std::max(worst_displacement, std::abs(probe.displacement[2] - acceleration * since * since / 2) /
                                           (largest * parameters.time.duration / 2));
      worst_stress = std::max(worst_stress, std::abs(probe.stress[2] - density * c * acceleration * since) /
                                                (density * c * largest));
    }
    const double reaction = density * c * acceleration * t * width * thickness;
    worst_reaction =
        std::max(worst_reaction, std::abs(row.load - reaction) / (density * c * largest * width * thickness));
  }
  std::printf(
      "wave: off by %.2e (velocity), %.2e (displacement), %.2e (stress), %.2e (reaction) of the largest\n",
      worst_velocity, worst_displacement, worst_stress, worst_reaction);
  EXPECT_LT(worst_velocity, 0.01);
  EXPECT_LT(worst_displacement, 0.003);
  EXPECT_LT(worst_stress, 0.01);
  EXPECT_LT(worst_reaction, 0.03);
  // The interval is a whole number of steps.
  EXPECT_NEAR(static_cast<double>(result.history.size()), 61, 5);
}

TEST_F(HistoryOfABar, TellsTheForceOfAnAbsorbingFace) {
  // As above; the wave leaves through the other end, which absorbs rho c v per area.
  parameters.time.start = input::Start::rest;
  parameters.time.integrator = input::Integrator::verlet;
  parameters.time.duration = 6e-5;
  const double acceleration = 1e5;
  add(Face::z_max, BoundaryKind::velocity, {true, true, true}, 0, acceleration);
  add(Face::z_min, BoundaryKind::absorbing, {}, 0, 0);
  const SampleResult result = run();
  const double c = std::sqrt(parameters.materials[0].youngs_modulus / parameters.materials[0].density);
  const double impedance = parameters.materials[0].density * c * width * thickness;
  const double largest = impedance * acceleration * (parameters.time.duration - length / c);
  double worst_force = 0, worst_reaction = 0;
  for (const HistoryRow& row : result.history) {
    const double t = row.energy.time;
    const double force = impedance * acceleration * std::max(0.0, t - length / c);
    worst_force = std::max(worst_force, std::abs(row.force[1][2] + force) / largest);
    worst_reaction = std::max(worst_reaction, std::abs(row.load - impedance * acceleration * t) / largest);
  }
  std::printf(
      "force of the absorbing face: off by %.2e of the largest; reaction at the other end, where nothing "
      "comes "
      "back: %.2e; energy error %.2e\n",
      worst_force, worst_reaction, result.energy_error);
  EXPECT_LT(worst_force, 0.01);
  EXPECT_LT(worst_reaction, 0.03);
  EXPECT_LT(result.energy_error, 1e-3);
  EXPECT_GT(result.energy.back().dissipated, 0);
}

TEST_F(HistoryOfABar, TellsEveryPhaseAndTheLoadBetween) {
  add(Face::z_min, BoundaryKind::fix, {true, true, true}, 0, 0);
  add(Face::z_max, BoundaryKind::force, {}, 0, 10);
  parameters.specimen.size = {0.002, 0.004, 0.012};
  n_cells = 12;
  parameters.output.probes.clear();
  parameters.materials[0] = test::epoxy();
  parameters.fracture.impulse = 1e5;
  // A first phase in which nothing breaks.
  parameters.time.start = input::Start::equilibrium;
  parameters.time.arrest = 1.5e-6;
  const SampleResult result = run();
  std::int32_t last = 0;
  for (std::size_t i = 1; i < result.history.size(); ++i) {
    const auto &before = result.history[i - 1], &row = result.history[i];
    EXPECT_GE(row.load_time, before.load_time) << i;
    EXPECT_GE(row.energy.broken, before.energy.broken) << i;
    EXPECT_TRUE(row.phase == 0 || row.phase == last || row.phase == last + 1) << i;
    last = std::max(last, row.phase);
  }
  std::printf("%zu rows, %d dynamic phases\n", result.history.size(), last);
  EXPECT_EQ(last, 2);
  EXPECT_EQ(last, result.counts.dynamic_phases);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
