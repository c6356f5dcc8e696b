// SPDX-License-Identifier: GPL-3.0-or-later
// Where cracks start with a strength and a toughness: smooth bodies break at the strength, slots at the load
// that the toughness gives.
#include "crackle/dynamics/sample_run.h"
#include "support/box_mesh.h"
#include "support/job.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace crackle::dynamics {
namespace {

using input::BoundaryKind;
using input::Face;

/// A bar of epoxy in tension. From the toughness alone its coarse tetrahedra would get 20 MPa.
input::Parameters bar() {
  input::Parameters parameters;
  parameters.material = test::epoxy();
  parameters.fracture = {.strength = 70e6, .exponent = 2, .impulse = 1e4, .toughness = 93};
  parameters.specimen.size = {4e-3, 4e-3, 12e-3};
  parameters.mesh.spacing = parameters.mesh.notch_spacing = 1.2e-3;
  parameters.time.duration = 2e-5;
  parameters.time.integrator = input::Integrator::verlet;
  parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {false, false, true}));
  parameters.boundaries.push_back(test::boundary(Face::x_min, BoundaryKind::fix, {true, false, false}));
  parameters.boundaries.push_back(test::boundary(Face::y_min, BoundaryKind::fix, {false, true, false}));
  parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10}));
  return parameters;
}

double first_break_load(const input::Parameters& parameters) {
  const parallel::Communicator self(MPI_COMM_SELF);
  return run_sample(self, parameters, test::whole(test::realization(parameters))).first_break_load;
}

TEST(Nucleation, SmoothBarBreaksAtItsStrength) {
  auto parameters = bar();
  const double area = parameters.specimen.size[0] * parameters.specimen.size[1];
  const double both = first_break_load(parameters);
  parameters.fracture.strength = 0;
  const double toughness_only = first_break_load(parameters);
  std::printf("first break over strength times area: %.4f (reference 1), with the toughness alone %.3f\n",
              both / (70e6 * area), toughness_only / (70e6 * area));
  EXPECT_NEAR(both, 70e6 * area, 1e-3 * 70e6 * area);
  EXPECT_LT(toughness_only, 0.5 * both);
}

TEST(Nucleation, SlotBreaksAtTheLoadOfTheToughness) {
  auto parameters = bar();
  input::Notch notch;
  notch.at = 6e-3;
  notch.depth = 1.5e-3;
  notch.height = 0.6e-3;
  parameters.specimen.notches.push_back(notch);
  parameters.mesh.notch_spacing = 0.6e-3;
  parameters.mesh.growth = 0.2;
  const double both = first_break_load(parameters);
  parameters.fracture.strength = 0;
  const double toughness_only = first_break_load(parameters);
  std::printf("first break at a slot: %.3f N with strength and toughness, %.3f N with the toughness alone\n",
              both, toughness_only);
  EXPECT_EQ(both, toughness_only);
}

/// Fine tetrahedra need more than the strength to take the toughness.
TEST(Nucleation, TheHigherThresholdHolds) {
  auto parameters = bar();
  parameters.fracture.strength = 5e6;
  const double both = first_break_load(parameters);
  parameters.fracture.strength = 0;
  EXPECT_EQ(both, first_break_load(parameters));
}

}  // namespace
}  // namespace crackle::dynamics
