// SPDX-License-Identifier: GPL-3.0-or-later
// A quenched bar has the same bits on any number of ranks and after an interruption.
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

using input::BoundaryKind;
using input::Face;

input::Parameters quenched_bar() {
  input::Parameters parameters;
  parameters.specimen.size = {0.004, 0.004, 0.012};
  parameters.materials[0] = {70e9, 0.23, 2500};
  parameters.fracture = {.strength = 35e6, .exponent = 2, .impulse = 1e4};
  parameters.time.duration = 1e-5;
  parameters.time.arrest = 2e-6;
  parameters.output.frames = 2;
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}),
                           test::boundary(Face::z_max, BoundaryKind::fix, {true, true, true})};
  auto& quench = parameters.initial_stresses.emplace_back();
  quench.along = 0;
  quench.kind = input::InitialStressKind::temperature;
  quench.expansion = 9e-6;
  quench.temperature = {{0, -100}, {0.0015, 0}};
  quench.history = {{0, 0}, {0.4, 0.4}};
  auto& tempered = parameters.initial_stresses.emplace_back();
  tempered.along = 1;
  tempered.kind = input::InitialStressKind::surface;
  tempered.surface = -20e6;
  return parameters;
}

TEST(InitialStress, HasTheSameBitsOnAnyNumberOfRanksAndAfterAnInterruption) {
  const auto mesh = test::make_box({.size = {0.004, 0.004, 0.012}, .cells = {3, 3, 9}, .disturbance = 0.2});
  const parallel::Communicator world(test::group()), self(MPI_COMM_SELF);
  const auto part = geometry::split(mesh, geometry::partition(mesh, world.size()))[index(world.rank())];
  for (const auto release : {input::Release::element, input::Release::facet}) {
    auto parameters = quenched_bar();
    parameters.fracture.release = release;
    if (release == input::Release::facet) parameters.fracture.release_time = 2e-7;
    const auto together = run_sample(world, parameters, part);
    const auto pieces = in_two_pieces(world, parameters, part);
    if (!world.is_root()) continue;
    std::printf("%s after %zu breaks in %lld dynamic phases, energy error %.1e\n",
                to_string(together.outcome).c_str(), together.breaks.size(),
                static_cast<long long>(together.counts.dynamic_phases), together.energy_error);
    EXPECT_GT(together.breaks.size(), 5U);
    EXPECT_GE(together.counts.dynamic_phases, 1);
    EXPECT_LT(together.energy_error, 1e-3);
    test::expect_same_course(together, pieces);
    if (world.size() > 1)
      test::expect_same_course(
          test::reference([&] { return run_sample(self, parameters, test::whole(mesh)); }), together);
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
