// SPDX-License-Identifier: GPL-3.0-or-later
// One sample shared by the ranks of a group: the same bits as on one rank.
#include "crackle/dynamics/sample_run.h"
#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdio>

namespace crackle::dynamics {
namespace {

using input::BoundaryKind;
using input::Face;

/// A bar that is torn apart from rest by a sudden traction: it breaks in many places.
input::Parameters torn_bar() {
  input::Parameters parameters;
  parameters.specimen.size = {0.002, 0.004, 0.012};
  parameters.material = test::epoxy();
  parameters.fracture = {.strength = 35e6, .exponent = 2, .impulse = 1e4};
  parameters.time.start = input::Start::rest;
  parameters.time.duration = 2.5e-5;
  parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}));
  parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::traction, {}, {0, 3e6, 22e6}));
  parameters.output.frames = 3;
  return parameters;
}

/// The sample on all ranks and on one: equal to the last bit.
void compare(const input::Parameters& parameters, std::size_t least_breaks) {
  const auto mesh =
      test::make_box({.size = parameters.specimen.size, .cells = {3, 5, 14}, .disturbance = 0.2});
  const parallel::Communicator world(MPI_COMM_WORLD);
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto parts = geometry::split(mesh, geometry::partition(mesh, world.size()));
  const auto shared = run_sample(world, parameters, parts[static_cast<std::size_t>(world.rank())]);
  const auto alone = run_sample(self, parameters, test::whole(mesh));
  if (!world.is_root()) return;

  std::printf("%d ranks: %zu breaks, %s, energy error %.1e, %lld restarts\n", world.size(),
              shared.breaks.size(), to_string(shared.outcome).c_str(), shared.energy_error,
              static_cast<long long>(shared.counts.range_restarts));
  ASSERT_GT(alone.breaks.size(), least_breaks) << "the case must break";
  EXPECT_EQ(shared.stable_step, alone.stable_step);
  EXPECT_EQ(shared.onset_force, alone.onset_force);
  EXPECT_EQ(shared.counts.solver_iterations, alone.counts.solver_iterations);
  EXPECT_EQ(shared.counts.range_restarts, alone.counts.range_restarts);
  EXPECT_EQ(shared.outcome, alone.outcome);
  ASSERT_EQ(shared.breaks.size(), alone.breaks.size());
  for (std::size_t i = 0; i < alone.breaks.size(); ++i) {
    EXPECT_EQ(shared.breaks[i].tetrahedron, alone.breaks[i].tetrahedron);
    EXPECT_EQ(shared.breaks[i].phase_time, alone.breaks[i].phase_time);
    EXPECT_EQ(shared.breaks[i].released_energy, alone.breaks[i].released_energy);
    EXPECT_EQ(shared.breaks[i].cut, alone.breaks[i].cut);
  }
  ASSERT_EQ(shared.energy.size(), alone.energy.size());
  for (std::size_t i = 0; i < alone.energy.size(); ++i) {
    EXPECT_EQ(shared.energy[i].kinetic, alone.energy[i].kinetic);
    EXPECT_EQ(shared.energy[i].strain, alone.energy[i].strain);
    EXPECT_EQ(shared.energy[i].external, alone.energy[i].external);
    EXPECT_EQ(shared.energy[i].released, alone.energy[i].released);
  }
  ASSERT_EQ(shared.frames.size(), alone.frames.size());
  for (std::size_t i = 0; i < alone.frames.size(); ++i) {
    EXPECT_EQ(shared.frames[i].displacement, alone.frames[i].displacement);
    EXPECT_EQ(shared.frames[i].velocity, alone.frames[i].velocity);
  }
}

class SampleOnManyRanks : public ::testing::TestWithParam<input::Precision> {};

TEST_P(SampleOnManyRanks, HasTheBitsOfOneRank) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  compare(parameters, 50);
}

TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankFromQuasiStaticLoadingOn) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.time.start = input::Start::quasi_static;
  parameters.boundaries.back() = test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10});
  compare(parameters, 20);
}

/// Facets and the tie rule, whose edges may lie between two ghosts, and a strength that differs from one
/// tetrahedron to the next.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankWithFacetsAndToughness) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.fracture.release = input::Release::facet;
  parameters.fracture.strength = 0;
  parameters.fracture.toughness = 70;
  compare(parameters, 50);
  parameters.time.start = input::Start::quasi_static;
  parameters.boundaries.back() = test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10});
  compare(parameters, 20);
}

INSTANTIATE_TEST_SUITE_P(Precisions, SampleOnManyRanks,
                         ::testing::Values(input::Precision::mixed, input::Precision::double_),
                         [](const auto& info) {
                           return info.param == input::Precision::mixed ? "Mixed" : "Double";
                         });

}  // namespace
}  // namespace crackle::dynamics
