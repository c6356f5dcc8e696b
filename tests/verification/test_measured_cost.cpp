// SPDX-License-Identifier: GPL-3.0-or-later
// The measurement of a sample's cost; its results, not the times.
#include "ensemble/estimate.h"

#include "dynamics/explicit_phase.h"
#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <cmath>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

/// A slotted strip pulled until it breaks.
input::Parameters strip() {
  input::Parameters parameters;
  parameters.specimen.size = {0.002, 0.01, 0.02};
  parameters.materials[0] = test::epoxy();
  parameters.fracture = {.strength = 35e6, .exponent = 2, .impulse = 1e4};
  parameters.time.duration = 4e-5;
  parameters.time.step = 5e-8;
  auto pull = test::boundary(Face::z_max, BoundaryKind::force, {true, true, true}, {0, 0, 0});
  pull.rate = {0, 0, 5};
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}), pull};
  return parameters;
}

const geometry::Realization& slotted() {
  static const auto mesh = test::make_box(
      {.size = {0.002, 0.01, 0.02},
       .cells = {3, 12, 25},
       .disturbance = 0.15,
       .removed = [](const geometry::Point& p) { return p[1] < 0.003 && std::abs(p[2] - 0.01) < 0.0005; }});
  return mesh;
}

constexpr int n_frames = 11;

TEST(MeasuredCost, HasEveryPartOfASample) {
  const auto cost = measure_cost(strip(), n_frames, slotted(), 1e9);
  EXPECT_TRUE(cost.outlook.breaks);
  EXPECT_GT(cost.setup, 0);
  EXPECT_GT(cost.first_solve, 0);
  EXPECT_GT(cost.next_solve, 0);
  EXPECT_GT(cost.phase_start, 0);
  EXPECT_GT(cost.step, 0);
  // A cracking body does not arrest at once.
  EXPECT_GT(cost.n_steps, 100);
  EXPECT_LE(cost.n_steps, 800);
}

TEST(MeasuredCost, IsThatOfTheEngine) {
  auto parameters = strip();
  parameters.time.engine = input::Engine::petsc;
  const auto petsc = measure_cost(parameters, n_frames, slotted(), 1e9);
  const auto fixed_point = measure_cost(strip(), n_frames, slotted(), 1e9);
  EXPECT_GT(petsc.n_steps, 100);
  EXPECT_GT(petsc.step, fixed_point.step);
}

TEST(MeasuredCost, EndsAtTheFirstLookAfterItsTime) {
  EXPECT_EQ(measure_cost(strip(), n_frames, slotted(), 0).n_steps, dynamics::steps_per_poll);
}

TEST(MeasuredCost, SeesThatNoLoadBreaksTheBody) {
  auto parameters = strip();
  parameters.boundaries[1].rate = {};
  parameters.boundaries[1].value = {0, 0, 1};
  const auto cost = measure_cost(parameters, n_frames, slotted(), 0);
  EXPECT_FALSE(cost.outlook.breaks);
  EXPECT_GT(cost.first_solve, 0);
  EXPECT_EQ(cost.next_solve, 0);
}

TEST(MeasuredCost, OfABodyThatStartsAtRestHasNoSolves) {
  auto parameters = strip();
  parameters.time.start = input::Start::rest;
  const auto cost = measure_cost(parameters, n_frames, slotted(), 0);
  EXPECT_TRUE(cost.outlook.breaks);
  EXPECT_EQ(cost.first_solve, 0);
  EXPECT_EQ(cost.next_solve, 0);
  EXPECT_GT(cost.step, 0);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
