// SPDX-License-Identifier: GPL-3.0-or-later
// The record of a testing machine: from which conditions, with which sign, and until when.
#include "dynamics/machine_load.h"
#include "dynamics/sample_run.h"

#include "support/box_mesh.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using mechanics::governing_conditions;
using plane::Face;

constexpr std::array<bool, 3> all{true, true, true};

std::vector<int> numbers(const input::Parameters& parameters) {
  std::vector<int> found;
  for (const auto& one : governing_conditions(parameters)) found.push_back(one.condition);
  return found;
}

/// A support, a dead load to the side, a grip that pulls up, and a second one.
input::Parameters pulled() {
  input::Parameters parameters;
  parameters.boundaries = {
      test::boundary(Face::z_min, BoundaryKind::fix, all),
      test::boundary(Face::y_max, BoundaryKind::force, {}, {0, -7, 0}),
      test::boundary(Face::z_max, BoundaryKind::displacement, {false, true, true}, {}, {0, 3e-6, -4e-6}),
      test::boundary(Face::z_max, BoundaryKind::displacement, {false, false, true}, {}, {0, 0, -1e-6})};
  return parameters;
}

TEST(GoverningConditions, AreWhatChangesBeforeWhatOnlyLoads) {
  auto parameters = pulled();
  ASSERT_THAT(numbers(parameters), testing::ElementsAre(2));
  const Vector along = governing_conditions(parameters)[0].direction;
  EXPECT_NEAR(along[1], 0.6, 1e-15);
  EXPECT_NEAR(along[2], -0.8, 1e-15);
  parameters.boundaries.resize(2);
  ASSERT_THAT(numbers(parameters), testing::ElementsAre(1));
  EXPECT_EQ(governing_conditions(parameters)[0].direction, (Vector{0, -1, 0}));
  parameters.boundaries.resize(1);
  EXPECT_THAT(numbers(parameters), testing::IsEmpty());
}

TEST(GoverningConditions, ShareANameOrAreNamed) {
  auto parameters = pulled();
  parameters.boundaries[2].name = parameters.boundaries[3].name = "grips";
  EXPECT_THAT(numbers(parameters), testing::ElementsAre(2, 3));
  parameters.governing = 1;
  EXPECT_THAT(numbers(parameters), testing::ElementsAre(1));
  parameters.governing = 3;
  EXPECT_THAT(numbers(parameters), testing::ElementsAre(2, 3)) << "all of its name belong to it";
  parameters.boundaries[0].name = "base";
  parameters.governing = "base";
  const auto base = governing_conditions(parameters);
  ASSERT_EQ(base.size(), 1U);
  EXPECT_TRUE(base[0].is_support);
  EXPECT_NEAR(base[0].direction[2], 0.8, 1e-15) << "against the drive";
}

TEST(GoverningConditions, TurnRoundWithTheirHistory) {
  input::Parameters parameters;
  parameters.boundaries = {test::boundary(Face::z_max, BoundaryKind::force, {}, {0, 0, 5})};
  parameters.boundaries[0].history = {{0, 0}, {1, -1}, {2, 3}};
  EXPECT_EQ(governing_conditions(parameters)[0].direction, (Vector{0, 0, -1}));
}

HistoryRow moment(int phase, double time, double load, double displacement, double work) {
  HistoryRow row;
  row.phase = phase;
  row.energy.time = time;
  row.energy.external = work;
  row.load = load;
  row.load_displacement = displacement;
  return row;
}

TEST(LoadResults, EndAtSeparation) {
  SampleResult result;
  result.counts.dynamic_phases = 2;
  result.history = {moment(0, 0, 0, 0, 0),     moment(0, 0, 9.995, 1, 5),  moment(0, 0, 10, 1.1, 5.5),
                    moment(1, 9, 9, 1.1, 6),   moment(0, 0, 8, 1.2, 7),    moment(2, 0, 8, 1.2, 7),
                    moment(2, 1, 7, 1.2, 7.5), moment(2, 2, -3, 1.2, 7.6), moment(2, 3, 50, 1.2, 9)};
  result.separated_at = 1.5;
  LoadResults found = load_results(result);
  EXPECT_EQ(found.peak_load, 10);
  EXPECT_EQ(found.displacement_at_peak, 1) << "within 0.1 %";
  EXPECT_EQ(found.work_of_fracture, 7.5);
  result.separated_at = SampleResult::none;
  found = load_results(result);
  EXPECT_EQ(found.peak_load, 50) << "of a force that goes on";
  EXPECT_EQ(found.work_of_fracture, 9);
  result.load_is_reaction = true;
  result.onset_force = 8;
  EXPECT_EQ(load_results(result).peak_load, 10) << "the rest is inertia";
  result.onset_force = SampleResult::none;
  EXPECT_EQ(load_results(result).peak_load, 50) << "from rest, inertia is the load";
}

TEST(LoadResults, EndAtThePeakIfTheLastLoadIsTheLargest) {
  SampleResult result;
  for (const auto& [loads, expected] : {std::pair{std::array{0.0, 10.0, 8.0, 12.0}, true},
                                        {std::array{0.0, 12.0, 8.0, 11.995}, true},
                                        {std::array{0.0, 12.0, 8.0, 11.0}, false},
                                        {std::array{0.0, 0.0, 0.0, 0.0}, false}}) {
    result.history.clear();
    for (const double load : loads) result.history.push_back(moment(0, 0, load, 0, 0));
    EXPECT_EQ(load_results(result).end_at_peak, expected) << loads[1] << ' ' << loads[3];
  }
  EXPECT_FALSE(load_results({}).end_at_peak);
}

TEST(LoadResults, InterpolateTheDisplacementBetweenMoments) {
  std::vector<HistoryRow> history(3);
  for (std::size_t i = 0; i < history.size(); ++i) {
    history[i].load_time = static_cast<double>(i * i);
    history[i].load_displacement = 10 * history[i].load_time;
  }
  EXPECT_NEAR(load_displacement_at(history, 2.5), 25, 1e-12);
  EXPECT_EQ(load_displacement_at(history, 4), 40);
  EXPECT_EQ(load_displacement_at(history, 9), 40) << "the last moment's";
  EXPECT_EQ(load_displacement_at(history, -1), 0);
}

TEST(LoadResults, AreUnknownWithoutAHistory) {
  EXPECT_TRUE(std::isnan(load_displacement_at({}, 1)));
  EXPECT_TRUE(std::isnan(load_results({}).peak_load));
  EXPECT_TRUE(std::isnan(load_results({}).work_of_fracture));
}

/// A bar of 2 x 4 x 12 mm pulled until it breaks.
class PulledBar : public testing::Test {
protected:
  PulledBar() {
    parameters.output.frames = 0;
    parameters.boundaries = {
        test::boundary(Face::z_min, BoundaryKind::fix, all),
        test::boundary(Face::z_max, BoundaryKind::displacement, {false, false, true}, {}, {0, 0, 1e-6})};
  }
  SampleResult run() {
    const auto mesh =
        test::make_box({.size = parameters.specimen.size, .cells = {2, 4, 12}, .disturbance = 0.2});
    return run_sample(parallel::Communicator(MPI_COMM_SELF), parameters, parameters.output,
                      test::whole(mesh));
  }
  static double largest_load(const SampleResult& result) {
    return std::ranges::max_element(result.history, {}, &HistoryRow::load)->load;
  }
  input::Parameters parameters = test::brittle({0.002, 0.004, 0.012});
};

TEST_F(PulledBar, HasItsPeakBeforeItReboundsFromTheGrip) {
  const SampleResult result = run();
  ASSERT_EQ(result.outcome, Outcome::separated);
  ASSERT_FALSE(std::isnan(result.separated_at));
  const LoadResults found = load_results(result);
  std::printf("peak %.6g N of %.6g N, separated at %.3g us\n", found.peak_load, largest_load(result),
              1e6 * result.separated_at);
  EXPECT_NEAR(found.peak_load, result.onset_force, 1e-2 * result.onset_force);
  EXPECT_LT(found.peak_load, largest_load(result)) << "inertia is no load";
  EXPECT_GT(found.displacement_at_peak, 0);
  EXPECT_LT(std::ranges::min_element(result.history, {}, &HistoryRow::load)->load, 0)
      << "pieces push back against their grips";
  // The triangle under the curve of a body that is linear up to its break.
  EXPECT_NEAR(found.work_of_fracture, 0.5 * found.peak_load * found.displacement_at_peak,
              0.1 * found.work_of_fracture);
}

TEST_F(PulledBar, HasItsPeakWhateverTheIntervalOfTheHistory) {
  parameters.time.start = input::Start::rest;
  parameters.time.integrator = input::Integrator::verlet;
  auto& grip = parameters.boundaries[1];
  for (const double duration : {4e-5, 1e-3}) {
    parameters.time.duration = duration;
    grip = test::boundary(Face::z_max, BoundaryKind::force, {}, {0, 0, 10}, {});
    grip.history = {{0, 0}, {2e-6, 1}, {4e-6, 0}};
    for (const std::optional<double> interval : {std::optional<double>(), std::optional(5e-6)}) {
      parameters.output.history = interval;
      const LoadResults pulse = run().loads;
      EXPECT_EQ(pulse.peak_load, 10);
      EXPECT_GT(pulse.displacement_at_peak, 0);
    }
  }
  parameters.time.duration = 4e-5;
  grip = test::boundary(Face::z_max, BoundaryKind::velocity, {false, false, true}, {0, 0, 5});
  parameters.output.history.reset();
  const SampleResult fine = run();
  parameters.output.history = 3e-6;
  const SampleResult coarse = run();
  ASSERT_EQ(fine.outcome, Outcome::separated);
  EXPECT_LT(coarse.history.size(), 20U);
  EXPECT_EQ(coarse.loads.peak_load, fine.loads.peak_load);
  EXPECT_EQ(coarse.loads.displacement_at_peak, fine.loads.displacement_at_peak);
  EXPECT_EQ(coarse.loads.work_of_fracture, fine.loads.work_of_fracture);
}

TEST_F(PulledBar, HasTheSameLoadAtItsSupport) {
  const SampleResult at_grip = run();
  parameters.governing = 0;
  const SampleResult at_support = run();
  EXPECT_NEAR(at_support.onset_force, at_grip.onset_force, 1e-6 * at_grip.onset_force);
  EXPECT_NEAR(at_support.first_break_load, at_grip.first_break_load, 1e-6 * at_grip.first_break_load);
  EXPECT_EQ(at_support.onset_time, at_grip.onset_time);
  EXPECT_EQ(load_results(at_support).displacement_at_peak, 0);
}

TEST_F(PulledBar, AddsUpTwoGripsOfOneName) {
  const double whole = run().onset_force;
  auto& grip = parameters.boundaries.back();
  auto other = grip;
  grip.region[1].second = 0.0021;
  other.region[1].first = 0.0021;
  parameters.boundaries.push_back(other);
  const double half = run().onset_force;
  parameters.boundaries[1].name = parameters.boundaries[2].name = "grips";
  const SampleResult both = run();
  std::printf("onset %.6g N, of one grip %.6g N, of both %.6g N\n", whole, half, both.onset_force);
  EXPECT_NEAR(both.onset_force, whole, 1e-6 * whole);
  EXPECT_LT(half, 0.7 * whole);
}

TEST_F(PulledBar, HasThePressureTimesItsAreaForALoad) {
  parameters.boundaries.back() = test::boundary(Face::z_max, BoundaryKind::pressure, {}, {}, {-1e5, 0, 0});
  const SampleResult result = run();
  const HistoryRow& row = result.history[1];
  EXPECT_NEAR(row.load, 1e5 * row.load_time * 0.002 * 0.004, 1e-9 * row.load) << "positive, since it pulls";
  EXPECT_GT(row.load_displacement, 0);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
