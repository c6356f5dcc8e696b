// SPDX-License-Identifier: GPL-3.0-or-later
// Loads end on fragments that come loose, bitwise equally on any number of ranks and after an interruption.
#include "crackle/common/index.h"
#include "crackle/dynamics/sample_run.h"
#include "crackle/parallel/collectives.h"

#include "support/box_mesh.h"
#include "support/group.h"
#include "support/same_result.h"
#include "two_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using input::Face;

/// A block under a blast on part of one face, held at the opposite one: the pressure crushes the face.
input::Parameters blasted_block() {
  input::Parameters parameters;
  parameters.specimen.size = {0.003, 0.008, 0.012};
  parameters.materials[0] = test::epoxy();
  parameters.fracture = {.strength = 25e6, .exponent = 2, .impulse = 1e4};
  parameters.time.start = input::Start::rest;
  parameters.time.integrator = input::Integrator::verlet;
  parameters.time.precision = input::Precision::double_;
  parameters.time.duration = 1e-5;
  parameters.time.step = 2e-8;
  auto pressure = test::boundary(Face::y_min, BoundaryKind::pressure, {}, {80e6, 0, 0});
  pressure.region[2] = {0.0035, 0.0085};
  pressure.history = {{0, 0}, {1e-6, 1}, {8e-6, 0.5}};
  parameters.boundaries = {pressure, test::boundary(Face::y_max, BoundaryKind::fix, {true, true, true})};
  parameters.output.frames = 3;
  return parameters;
}

/// Pulled at its end, part of which is a finger on a thin neck, which tears off first.
input::Parameters bar_with_finger() {
  auto parameters = blasted_block();
  parameters.specimen.size = {0.003, 0.006, 0.012};
  parameters.time = {};
  parameters.time.precision = input::Precision::double_;
  parameters.time.duration = 2e-4;
  parameters.time.arrest = 5e-5;
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}),
                           test::boundary(Face::z_max, BoundaryKind::traction, {}, {}, {0, 0, 1e6})};
  return parameters;
}

class LooseLoads : public testing::Test {
protected:
  SampleResult run(const parallel::Communicator& group, const input::Parameters& parameters) const {
    return run_sample(group, parameters, part(group));
  }
  geometry::Subdomain part(const parallel::Communicator& group) const {
    return geometry::split(mesh_, geometry::partition(mesh_, group.size()))[index(group.rank())];
  }

  parallel::Communicator world_{test::group()}, self_{MPI_COMM_SELF};
  geometry::Realization mesh_ =
      test::make_box({.size = blasted_block().specimen.size, .cells = {4, 10, 15}, .disturbance = 0.2});
};

/// The largest component of the load exerted by a condition.
double load(const HistoryRow& row, std::size_t condition) {
  double largest = 0;
  for (const double component : row.force[condition]) largest = std::max(largest, std::abs(component));
  return largest;
}

/// The pressure ends on fragments that fly away, and so does its work.
void expect_no_work_on_fragments(const SampleResult& result) {
  ASSERT_GT(result.breaks.size(), 100U);
  const auto at_peak =
      std::ranges::find_if(result.history, [](const HistoryRow& row) { return row.load_time >= 2e-6; });
  ASSERT_NE(at_peak, result.history.end());
  const auto& end = result.history.back();
  const double whole_load = 80e6 * 0.003 * 0.005;
  std::printf(
      "%zu breaks, external work %.3g J at 2 us, %.3g J at the end, load %.3g of %.3g N, error %.1e\n",
      result.breaks.size(), at_peak->energy.external, end.energy.external, load(end, 0), 0.5 * whole_load,
      result.energy_error);
  EXPECT_LT(end.energy.external, 6 * at_peak->energy.external) << "fragments are pushed on";
  EXPECT_LT(load(end, 0), 0.4 * whole_load);
  EXPECT_LT(result.energy_error, 1e-4);
}

TEST_F(LooseLoads, EndWithTheSameBitsOnAnyNumberOfRanksAndAfterAnInterruption) {
  for (const auto integrator : {input::Integrator::verlet, input::Integrator::bilateral4}) {
    auto parameters = blasted_block();
    parameters.time.integrator = integrator;
    const auto together = run(world_, parameters);
    const auto pieces = in_two_pieces(world_, parameters, part(world_));
    if (!world_.is_root()) continue;
    expect_no_work_on_fragments(together);
    test::expect_same_course(together, pieces);
    if (world_.size() > 1)
      test::expect_same_course(test::reference([&] { return run(self_, parameters); }), together);
  }
}

TEST_F(LooseLoads, EndInTheOtherEngineToo) {
  auto parameters = blasted_block();
  parameters.time.duration = 4e-6;
  const auto result = run(world_, parameters);
  parameters.time.engine = input::Engine::petsc;
  const auto other = run(world_, parameters);
  if (!world_.is_root()) return;
  ASSERT_EQ(result.history.size(), other.history.size());
  const auto& end = result.history.back();
  const auto& other_end = other.history.back();
  EXPECT_LT(load(end, 0), 0.8 * 80e6 * 0.003 * 0.005);
  EXPECT_NEAR(load(end, 0), load(other_end, 0), 1e-9 * load(end, 0));
  EXPECT_NEAR(end.energy.external, other_end.energy.external, 1e-6 * end.energy.external);
  EXPECT_LT(other.energy_error, 1e-4);
}

TEST_F(LooseLoads, LeaveTheRestOfTheLoadingToTheBody) {
  const auto parameters = bar_with_finger();
  // The finger is 1 mm wide on a neck of one cell; both it and the bar end in the loaded face.
  mesh_ = test::make_box(
      {.size = parameters.specimen.size, .cells = {3, 6, 12}, .removed = [](const geometry::Point& p) {
         if (p[2] < 0.008 || p[1] < 0.004) return false;
         return p[1] < 0.005 || (p[2] < 0.009 && p[0] > 0.001);
       }});
  const auto result = run(world_, parameters);
  const auto pieces = in_two_pieces(world_, parameters, part(world_));
  if (!world_.is_root()) return;
  test::expect_same_course(result, pieces);
  if (world_.size() > 1)
    test::expect_same_course(test::reference([&] { return run(self_, parameters); }), result);
  double most = 0;
  for (const HistoryRow& row : result.history) most = std::max(most, load(row, 1));
  std::printf("%s after %zu breaks, first at %.4g N, at most %.4g N, error %.1e\n",
              to_string(result.outcome).c_str(), result.breaks.size(), result.first_break_load, most,
              result.energy_error);
  EXPECT_EQ(result.outcome, Outcome::separated);
  EXPECT_GT(most, 1.5 * result.first_break_load) << "the bar bears more than its finger";
  EXPECT_LT(result.energy_error, 1e-5);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
