// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/estimate.h"

#include "dynamics/sample_run.h"
#include "support/box_mesh.h"

#include <gmock/gmock.h>

#include <cstdio>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

input::Parameters paper_like() {
  input::Parameters parameters;
  parameters.ensemble.samples = 200;
  parameters.specimen.size = {5e-3, 24.5e-3, 140e-3};
  parameters.materials[0] = {3.3e9, 0.38, 1180};
  parameters.time.duration = 100e-6;
  parameters.time.step = 5e-9;
  return parameters;
}

TEST(Estimate, CountsStepsAndForceEvaluations) {
  auto parameters = paper_like();
  auto phase = phase_work(parameters.time, 40e-9);
  EXPECT_EQ(phase.grid.step, 5e-9);
  EXPECT_EQ(phase.grid.n_steps, 20000);
  // Eight kicks in two steps, the last of which shares its force with the first of the next two.
  EXPECT_EQ(phase.force_evaluations, 70000);
  parameters.time.integrator = input::Integrator::verlet;
  phase = phase_work(parameters.time, 40e-9);
  EXPECT_EQ(phase.force_evaluations, 20000);
}

/// Cracks arrest where they relieve the load: between moved grips, and above all under thermal stresses (34
/// to 57 phases of a disc shrunk into a ring).
TEST(Estimate, ExpectsMorePhasesWhereCracksRelieveTheLoad) {
  const auto most = [](const input::Parameters& parameters) { return expected_phases(parameters).most; };
  auto parameters = paper_like();
  parameters.boundaries.resize(1);
  input::Boundary& condition = parameters.boundaries[0];
  condition.kind = input::BoundaryKind::force;
  condition.rate = {0, 0, 1};
  EXPECT_EQ(most(parameters), usual_phases);
  condition.kind = input::BoundaryKind::displacement;
  condition.rate = {0, 0, 1e-6};
  EXPECT_GE(most(parameters), 10);
  EXPECT_EQ(expected_phases(parameters).least, usual_phases);
  condition.kind = input::BoundaryKind::fix;
  condition.rate = {};
  EXPECT_EQ(most(parameters), usual_phases);
  parameters.initial_stresses.emplace_back().expansion = 9e-6;
  parameters.initial_stresses[0].temperature = {{0, -200}};
  EXPECT_EQ(most(parameters), usual_phases) << "there from the start";
  parameters.initial_stresses[0].history = {{0, 0}, {10, 1}};
  EXPECT_GE(most(parameters), 57);
  parameters.time.start = input::Start::rest;
  EXPECT_EQ(most(parameters), 1);
}

TEST(Estimate, AutomaticStepStaysBelowTheStableOneAndDividesTheDuration) {
  auto parameters = paper_like();
  parameters.time.step.reset();
  const auto grid = phase_work(parameters.time, 40e-9).grid;
  std::printf("step %.6g ns, %ld steps\n", grid.step * 1e9, static_cast<long>(grid.n_steps));
  EXPECT_LE(grid.step, 0.9 * 40e-9);
  EXPECT_GT(grid.step, 0.89 * 40e-9);
  EXPECT_DOUBLE_EQ(grid.step * static_cast<double>(grid.n_steps), 100e-6);
}

TEST(Estimate, RefusesAStepOverTheStableOne) {
  auto parameters = paper_like();
  parameters.time.step = 50e-9;
  try {
    phase_work(parameters.time, 40e-9);
    FAIL() << "a step over the stable one was accepted";
  } catch (const std::runtime_error& error) {
    std::printf("%s\n", error.what());
    EXPECT_THAT(error.what(), AllOf(StartsWith("time.step: 50 ns"), HasSubstr("stable step"),
                                    HasSubstr("40 ns"), HasSubstr("\"auto\"")));
  }
  EXPECT_THROW(phase_work(paper_like().time, 0), std::runtime_error);
}

TEST(Estimate, ArrestedPhasesAndEquilibriaCount) {
  auto parameters = paper_like();
  const double arrest_window = 0.4 * parameters.time.duration;
  EXPECT_EQ(sample_work(parameters.time, arrest_window, 1).full_durations, 1);
  EXPECT_EQ(sample_work(parameters.time, arrest_window, 1).solves, 2);
  const SampleWork three = sample_work(parameters.time, arrest_window, 3);
  const double share = arrest_window / parameters.time.duration;
  EXPECT_GT(three.full_durations, 1 + 2 * share);
  EXPECT_LT(three.full_durations, 1 + 2 * (share + 1));
  EXPECT_GT(three.solves, 2 + 3);
  parameters.time.duration = 1e-6;  // an arrest takes as long as a phase may last
  EXPECT_EQ(sample_work(parameters.time, arrest_window, 3).full_durations,
            1 + 2 * dynamics::max_phase_durations);
  parameters.time.start = input::Start::rest;
  EXPECT_EQ(sample_work(parameters.time, arrest_window, 3).phases, 1);
  EXPECT_EQ(sample_work(parameters.time, arrest_window, 3).solves, 0);
}

TEST(Estimate, MessagesFollowStepsAndIterations) {
  auto parameters = paper_like();
  MeasuredCost measured;
  measured.step = 3.5e-3;  // 1 ms for each force
  measured.first_solve = 0.8;
  measured.agreements = 3.0 / 32;
  measured.n_nodes = 54'000;
  const PhaseWork phase = phase_work(parameters.time, 40e-9);
  EXPECT_EQ(phase.exchanges, 4 * 20000);
  EXPECT_EQ(phase.bytes_per_ghost, 12);
  const SampleWork work{.phases = 1, .full_durations = 2};
  const GroupTraffic traffic = sample_cost(measured, phase, work, 0).traffic;
  EXPECT_NEAR(traffic.exchanges, 2 * 80000 + 100, 1e-6) << "100 iterations of the solver";
  EXPECT_NEAR(traffic.agreements, 2 * 20000 * 3 / 32 + 500, 1e-6);
  EXPECT_GT(traffic.repeated, 0.01);
  EXPECT_LT(traffic.repeated, 0.1);
  parameters.time.integrator = input::Integrator::verlet;
  parameters.time.precision = input::Precision::double_;
  EXPECT_EQ(phase_work(parameters.time, 40e-9).exchanges, 20000);
  EXPECT_EQ(phase_work(parameters.time, 40e-9).bytes_per_ghost, 24);
}

TEST(Estimate, CostIsTheSumOfItsParts) {
  const auto parameters = paper_like();
  MeasuredCost measured;
  measured.setup = 0.5;
  measured.first_solve = 6;
  measured.next_solve = 2;
  measured.phase_start = 0.25;
  measured.step = 1e-3;
  const PhaseWork phase = phase_work(parameters.time, 40e-9);
  const SampleWork work{.phases = 2, .full_durations = 1.5, .solves = 4};
  const SampleCost cost = sample_cost(measured, phase, work, 1);
  EXPECT_DOUBLE_EQ(cost.phase, 0.25 + 20);
  EXPECT_DOUBLE_EQ(cost.dynamic, 2 * 0.25 + 1.5 * 20);
  EXPECT_DOUBLE_EQ(cost.quasi_static, 6 + 4 * 2);
  EXPECT_DOUBLE_EQ(cost.total(), 30.5 + 14 + 1.5);
  // A body that no load breaks has no dynamic phase.
  measured.outlook.breaks = false;
  measured.next_solve = 0;
  EXPECT_DOUBLE_EQ(sample_cost(measured, phase, work, 1).total(), 6 + 1.5);
  // Only the one in which it moves from the equilibrium at the start.
  EXPECT_DOUBLE_EQ(sample_cost(measured, phase, {.phases_unbroken = 1}, 1).total(), 6 + 20.25 + 1.5);
}

const geometry::Realization& bar() {
  static const auto mesh =
      test::make_box({.size = {0.005, 0.005, 0.05}, .cells = {10, 10, 100}, .disturbance = 0.2});
  return mesh;
}

/// Plans of a bar of 60,000 tetrahedra.
std::vector<GroupPlan> plans(std::int64_t ranks, int samples, double mesh = 0.07,
                             input::MeshMakers makers = input::MeshMakers::automatic,
                             const GroupTraffic& traffic = {}) {
  static const PartSizes parts(bar(), 0, 64);
  input::Parameters parameters;
  parameters.ensemble.samples = samples;
  parameters.ensemble.meshes = makers;
  return make_plans(parts, static_cast<double>(bar().nodes.size()), parameters,
                    {.dynamic = 20, .quasi_static = 1.5, .setup = 0.5, .mesh = mesh, .traffic = traffic},
                    ranks);
}

TEST(Plans, ShareASampleByItsLargestPart) {
  const auto all = plans(17, 200);
  ASSERT_EQ(all.size(), 5U);
  EXPECT_EQ(all[0].tetrahedra, 60000);
  EXPECT_DOUBLE_EQ(all[0].sample_seconds, 22);
  // Half of them and one layer of the halo.
  EXPECT_GE(all[1].tetrahedra, 30000);
  EXPECT_LE(all[1].tetrahedra, 32500);
  EXPECT_DOUBLE_EQ(all[1].sample_seconds,
                   22 * static_cast<double>(all[1].tetrahedra) / 60000 + all[1].division_seconds);
  EXPECT_EQ(plans(1, 4).size(), 1U);
  EXPECT_EQ(plans(1000, 1).back().ranks, 16) << "smaller parts exchange rather than compute";
}

/// Of 20,000 steps with four exchanges each.
TEST(Plans, MessagesAndWhatEveryRankRepeatsCost) {
  constexpr GroupTraffic traffic{.exchanges = 8e4, .agreements = 2e3, .repeated = 0.5};
  const auto free = plans(17, 200);
  const auto all = plans(17, 200, 0.07, input::MeshMakers::automatic, traffic);
  ASSERT_EQ(all.size(), 5U);
  EXPECT_EQ(all[0].sample_seconds, 22) << "the estimate of one rank";
  EXPECT_EQ(all[0].efficiency, 1);
  EXPECT_EQ(all[0].memory, 0);
  for (std::size_t i = 1; i < all.size(); ++i) {
    std::printf("%d ranks: %.3f s, of which %.3f s messages, efficiency %.2f\n", all[i].ranks,
                all[i].sample_seconds, all[i].message_seconds, all[i].efficiency);
    const double n = all[i].ranks;
    EXPECT_LT(all[i].efficiency, all[i - 1].efficiency);
    EXPECT_GT(all[i].message_seconds, traffic.exchanges * 2e-6);
    const double share = static_cast<double>(all[i].tetrahedra) / 60000;
    EXPECT_NEAR(all[i].sample_seconds, free[i].sample_seconds + all[i].message_seconds + 0.5 * (1 - share),
                1e-4)
        << "the number of tetrahedra is rounded";
    EXPECT_DOUBLE_EQ(all[i].efficiency, 22 / (n * all[i].sample_seconds));
    EXPECT_LT(all[i].memory, all[i].root_memory);
  }
}

TEST(Plans, MemoryIsThatOfTheLargestPart) {
  const auto plan_of = [](double halo) {
    return make_plans(PartSizes(bar(), halo, 4), 11000, input::Parameters(), {.dynamic = 20}, 5).back();
  };
  const GroupPlan thin = plan_of(0);
  const GroupPlan thick = plan_of(0.005);
  ASSERT_GT(thick.tetrahedra, thin.tetrahedra + 3000);
  EXPECT_NEAR((thick.memory - thin.memory) / static_cast<double>(thick.tetrahedra - thin.tetrahedra), 393, 1);
}

TEST(Plans, FewRanksForManySamplesManyRanksForFew) {
  EXPECT_EQ(recommended(plans(17, 200)).ranks, 1);
  EXPECT_EQ(recommended(plans(17, 1)).ranks, 16);
  // Four samples on 16 workers: groups of four.
  EXPECT_EQ(recommended(plans(17, 4)).ranks, 4);
}

TEST(Plans, KnowWhenTheMasterIsTooSlow) {
  using enum input::MeshMakers;
  const GroupPlan few = plans(50, 1000, 0.07, master).front();
  EXPECT_FALSE(few.waits_for_master);
  EXPECT_EQ(plans(50, 1000, 0.07, automatic).front().wall_seconds, few.wall_seconds);
  EXPECT_GT(plans(50, 1000, 0.07, groups).front().wall_seconds, few.wall_seconds);
  const GroupPlan many = plans(100'000, 100'000, 0.07, master).front();
  EXPECT_TRUE(many.waits_for_master);
  EXPECT_DOUBLE_EQ(many.wall_seconds, 100'000 * 0.07 + 22);
  const GroupPlan by_groups = plans(100'000, 100'000).front();
  EXPECT_FALSE(by_groups.waits_for_master);
  EXPECT_DOUBLE_EQ(by_groups.wall_seconds, 2 * (22 + 0.07));
}

TEST(Estimate, OutputGrowsWithFramesNodesAndTetrahedra) {
  auto parameters = paper_like();
  const double with_frames = sample_file_size(parameters.output.frames, 54695, 293700);
  // For sample 0 of jobs/paper/clock-from-zero.toml.
  EXPECT_NEAR(with_frames, 13.27e6, 0.25 * 13.27e6);
  parameters.output.frames = 0;
  const double without = sample_file_size(parameters.output.frames, 54695, 293700);
  EXPECT_LT(without, 0.5 * with_frames);
  EXPECT_GT(sample_file_size(parameters.output.frames, 2 * 54695, 293700), without);
  EXPECT_GT(sample_file_size(parameters.output.frames, 54695, 2 * 293700), without);
  parameters.specimen = {
      {0.005, 0.0245, 0.14},
      {{plane::Face::y_min, 0.0675, 0.0055, 0.0006}, {plane::Face::y_max, 0.0725, 0.0055, 0.0006}}};
  parameters.sections.y.resize(5);
  // jobs/paper/shared-base/ensemble.h5
  EXPECT_NEAR(ensemble_file_size(parameters, 54695), 1.91e6, 0.25 * 1.91e6);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
