// SPDX-License-Identifier: GPL-3.0-or-later
// Body forces, initial velocities and factors: the same bits on any number of ranks and after an
// interruption.
#include "crackle/common/index.h"
#include "crackle/dynamics/sample_run.h"

#include "support/box_mesh.h"
#include "support/group.h"
#include "support/same_result.h"
#include "two_pieces.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BodyLoad;
using input::BoundaryKind;
using input::Face;
using input::LoadKind;

input::Parameters held_bar() {
  input::Parameters parameters;
  parameters.specimen.size = {0.002, 0.004, 0.012};
  parameters.materials[0] = test::epoxy();
  parameters.fracture = {.strength = 35e6, .exponent = 2, .impulse = 1e5};
  parameters.time.precision = input::Precision::double_;
  parameters.time.integrator = input::Integrator::verlet;
  parameters.time.duration = 1e-5;
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true})};
  parameters.output.frames = 4;
  return parameters;
}

/// Everything at once: flung outwards, turning, pulled unevenly.
input::Parameters flung_bar() {
  auto parameters = held_bar();
  parameters.time.start = input::Start::rest;
  BodyLoad fling, push, turn, gravity;
  fling.kind = LoadKind::velocity_gradient;
  fling.gradient = {Vector{0, 0, 0}, {0, 0, 50}, {0, 100, 3000}};
  push.kind = LoadKind::velocity;
  push.value = {1, 2, 0};
  turn.kind = LoadKind::angular_velocity;
  turn.angular_velocity = 5e3;
  turn.axis = {1, 0.5, 0};
  turn.history = {{0, 0}, {4e-6, 1}, {1, 1}};
  gravity.value = {0, 1e5, 0};
  parameters.loads = {fling, push, turn, gravity};
  auto pull = test::boundary(Face::z_max, BoundaryKind::traction, {}, {0, 0, 5e6});
  pull.factor = {1, {{0, 0}, {0.0013, 1}, {0.004, 0.5}}};
  auto drive = test::boundary(Face::z_min, BoundaryKind::velocity, {true, true, true}, {0, 0, -2});
  drive.factor = {0, {{0, 1}, {0.002, 0.5}}};
  parameters.boundaries = {drive, pull};
  return parameters;
}

/// Hangs from its end while gravity grows.
input::Parameters hanging_bar() {
  auto parameters = held_bar();
  parameters.time.arrest = 2.5e-6;
  BodyLoad gravity;
  gravity.rate = {0, 1e4, 1e5};
  parameters.loads = {gravity};
  return parameters;
}

TEST(BodyLoads, HaveTheSameBitsOnAnyNumberOfRanksAndAfterAnInterruption) {
  const parallel::Communicator world(test::group()), self(MPI_COMM_SELF);
  const geometry::Realization mesh =
      test::make_box({.size = held_bar().specimen.size, .cells = {2, 4, 10}, .disturbance = 0.2});
  const auto part = [&](const parallel::Communicator& group) {
    return geometry::split(mesh, geometry::partition(mesh, group.size()))[index(group.rank())];
  };
  for (const auto& [name, parameters] :
       {std::pair{"flung", flung_bar()}, std::pair{"hanging", hanging_bar()}}) {
    const auto together = run_sample(world, parameters, part(world));
    const auto pieces = in_two_pieces(world, parameters, part(world));
    if (!world.is_root()) continue;
    std::printf("%s: %zu breaks, %s, kinetic energy %.4g J at the start, energy error %.1e\n", name,
                together.breaks.size(), to_string(together.outcome).c_str(), together.energy.front().kinetic,
                together.energy_error);
    EXPECT_GT(together.breaks.size(), 20u);
    EXPECT_LT(together.energy_error, 0.02);
    test::expect_same_course(together, pieces);
    if (world.size() > 1)
      test::expect_same_course(test::reference([&] { return run_sample(self, parameters, part(self)); }),
                               together);
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
