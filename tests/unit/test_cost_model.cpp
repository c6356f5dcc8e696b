// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/cost_model.h"

#include "crackle/ensemble/base_points.h"
#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

const geometry::Realization& bar() {
  static const auto mesh =
      test::make_box({.size = {0.005, 0.005, 0.05}, .cells = {10, 10, 100}, .disturbance = 0.2});
  return mesh;
}

std::vector<GroupPlan> plans(std::int64_t ranks, std::int64_t samples, const Machine& machine) {
  input::Parameters parameters;
  parameters.time.integrator = input::Integrator::bilateral4;
  return make_plans(bar(), parameters, 80000, 1.5, machine, ranks, samples);
}

TEST(CostModel, SharesAreThoseOfThePartition) {
  EXPECT_EQ(largest_rank_work(bar(), 1).tetrahedra, 60000);
  EXPECT_EQ(largest_rank_work(bar(), 1).ghosts, 0);
  const RankWork two = largest_rank_work(bar(), 2);
  std::printf("2 ranks: %ld tetrahedra, %ld ghosts, %d neighbours\n", static_cast<long>(two.tetrahedra),
              static_cast<long>(two.ghosts), two.neighbours);
  // Half of them plus one layer of the halo; a cross-section of 11 x 11 nodes plus METIS's overhead.
  EXPECT_GE(two.tetrahedra, 30000);
  EXPECT_LE(two.tetrahedra, 32500);
  EXPECT_GE(two.ghosts, 121 / 2);
  EXPECT_LE(two.ghosts, 2 * 121);
  EXPECT_EQ(two.neighbours, 1);
  EXPECT_LE(largest_rank_work(bar(), 8).neighbours, 3);
}

TEST(CostModel, ForceTimeFollowsItsFormula) {
  Machine machine;
  machine.shared_updates_per_second = 1e8;
  machine.latency = 2e-6;
  machine.bandwidth = 1e9;
  const ForceTime time = force_time({.ranks = 4, .tetrahedra = 50000, .ghosts = 1000, .neighbours = 2},
                                    machine, input::Precision::mixed, 4);
  EXPECT_DOUBLE_EQ(time.computation, 5e-4);
  EXPECT_DOUBLE_EQ(time.exchange, 2 * 2e-6 + 12e3 / 1e9);
  EXPECT_DOUBLE_EQ(time.polls, 3 * 2 * 2e-6 / 32 / 4);
}

TEST(CostModel, TheRateFollowsTheEngine) {
  input::Time time;
  time.precision = input::Precision::double_;
  const double in_double = updates_per_core_second(time);
  time.engine = input::Engine::petsc;
  const double petsc = updates_per_core_second(time);
  EXPECT_LT(petsc, in_double);
  EXPECT_LT(in_double, updates_per_core_second({}));
  EXPECT_EQ(Machine(time).updates_per_second, petsc);
}

TEST(CostModel, ASampleIsItsForcesItsStaticPartAndTheRootsWork) {
  Machine machine(1e8);
  EXPECT_EQ(machine.shared_updates_per_second, shared_rate_share * 1e8);
  machine.root_updates_per_second = 60000;
  const auto all = plans(17, 200, machine);
  EXPECT_DOUBLE_EQ(all[0].sample_seconds, 80000 * 60000.0 / 1e8 + 1.5 + 1);
  // Static solves scale with ranks like force evaluations.
  const double faster = all[0].force.total() / all[1].force.total();
  EXPECT_GT(faster, 1.5);
  EXPECT_DOUBLE_EQ(all[1].sample_seconds, (80000 * 60000.0 / 1e8 + 1.5) / faster + 1);
}

TEST(CostModel, FewRanksForManySamplesManyRanksForFew) {
  const Machine machine;
  EXPECT_EQ(recommended(plans(17, 200, machine)).work.ranks, 1);
  EXPECT_EQ(recommended(plans(17, 1, machine)).work.ranks, 16);
  // Four samples on 16 workers: groups of four.
  EXPECT_EQ(recommended(plans(17, 4, machine)).work.ranks, 4);
  EXPECT_EQ(plans(17, 4, machine).size(), 5U);
  EXPECT_EQ(plans(1, 4, machine).size(), 1U);
}

TEST(CostModel, KnowsWhenTheMasterIsTooSlow) {
  const Machine machine;
  input::Parameters parameters;
  const auto made_by = [&](input::MeshMakers makers, std::int64_t ranks, std::int64_t samples) {
    parameters.ensemble.meshes = makers;
    return make_plans(bar(), parameters, 80000, 1.5, machine, ranks, samples).front();
  };
  using enum input::MeshMakers;
  const double mesh = 60000.0 / machine.mesh_updates_per_second;
  const GroupPlan few = made_by(master, 50, 1000);
  EXPECT_FALSE(few.waits_for_master);
  EXPECT_EQ(made_by(automatic, 50, 1000).wall_seconds, few.wall_seconds);
  EXPECT_GT(made_by(groups, 50, 1000).wall_seconds, few.wall_seconds);
  const GroupPlan many = made_by(master, 100'000, 100'000);
  EXPECT_TRUE(many.waits_for_master);
  EXPECT_GE(many.wall_seconds, 100'000 * mesh);
  const GroupPlan by_groups = made_by(automatic, 100'000, 100'000);
  EXPECT_FALSE(by_groups.waits_for_master);
  EXPECT_DOUBLE_EQ(by_groups.wall_seconds, 2 * (by_groups.sample_seconds + mesh));
}

TEST(CostModel, MeshesWithABaseOfTheirOwnTakeLonger) {
  input::Parameters parameters;
  parameters.ensemble.meshes = input::MeshMakers::master;
  const Machine machine;
  const auto with = [&](input::Base base) {
    parameters.mesh.base = base;
    return make_plans(bar(), parameters, 80000, 1.5, machine, 33, 200).front();
  };
  const GroupPlan shared = with(input::Base::shared), own = with(input::Base::own);
  EXPECT_FALSE(shared.waits_for_master);
  EXPECT_DOUBLE_EQ(own.sample_seconds, shared.sample_seconds);
  const double placing = placing_seconds(static_cast<double>(bar().nodes.size()));
  EXPECT_GT(placing, 0.1);
  EXPECT_NEAR(own.wall_seconds,
              own.waits_for_master
                  ? 200 * (placing + 60000 / machine.mesh_updates_per_second) + own.sample_seconds
                  : shared.wall_seconds + placing,
              1e-9);
}

TEST(CostModel, SlowNetworksMakeGroupsSmaller) {
  Machine slow;
  slow.latency = 1e-3;
  EXPECT_LT(recommended(plans(17, 1, slow)).work.ranks, 16);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
