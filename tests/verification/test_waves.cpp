// SPDX-License-Identifier: GPL-3.0-or-later
// Plane waves on disturbed meshes: P and S waves travel with their speeds, with an error of order 2 in space.
#include "crackle/dynamics/explicit_phase.h"
#include "crackle/dynamics/stable_step.h"
#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

namespace crackle::dynamics {
namespace {

using input::BoundaryKind;
using input::Face;

constexpr double length = 0.012;

/// A standing wave u_i = A cos(pi z / L) for one period of its exact frequency.
/// @param axis of the motion: 2 for the P wave, 0 for the S wave
/// @return error over the wave, in the mass norm
double error_of_standing_wave(int axis, int cells) {
  input::Parameters parameters;
  parameters.specimen.size = {0.002, 0.002, length};
  parameters.material = test::epoxy();
  // Walls that let the plane wave pass along them.
  for (const Face face : {Face::y_min, Face::y_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {false, true, false}));
  for (const Face face : {Face::x_min, Face::x_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {axis == 2, false, axis == 0}));
  const auto mesh = test::make_box(
      {.size = parameters.specimen.size, .cells = {cells / 6, cells / 6, cells}, .disturbance = 0.15});
  const auto subdomain = test::whole(mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  fracture::BreakableBody body(subdomain, parameters.material);
  const auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
  fracture::TulerButcher criterion({.strength = 1e15, .exponent = 2, .impulse = 1e4},
                                   subdomain.tetrahedra.size());
  const mechanics::IsotropicElasticity elasticity(parameters.material);
  const double modulus = axis == 2 ? elasticity.lambda + 2 * elasticity.mu : elasticity.mu;
  const double period = 2 * length / std::sqrt(modulus / parameters.material.density);

  MotionState state{parallel::NodeField(self, subdomain), parallel::NodeField(self, subdomain)};
  const double amplitude = 1e-6;
  const auto component = static_cast<std::size_t>(axis);
  for (std::size_t n = 0; n < subdomain.nodes.size(); ++n)
    state.displacement.local()[3 * n + component] =
        amplitude * std::cos(std::numbers::pi * subdomain.nodes[n][2] / length);
  const MotionContext context{&self, &body, &loads, parameters.material.density, criterion.strengths()};
  const EnergyAccount account(self, body);
  const auto& map = splitting(input::Integrator::bilateral4);
  const double stable =
      map.stability_limit / largest_frequency(self, subdomain, body.operators(), body.force());
  PhaseOptions options;
  const auto n_steps = 2 * static_cast<std::int64_t>(std::ceil(period / stable));
  options.grid = {period / static_cast<double>(n_steps), n_steps};
  const auto motion = make_fixed_point_motion(context, input::Precision::double_, 0, period, state);
  run_explicit_phase(context, *motion, criterion, map, account, 0, options, state);

  double error = 0, whole = 0;
  for (std::size_t n = 0; n < subdomain.nodes.size(); ++n) {
    const double mass = body.operators().node_mass[n];
    const double exact = amplitude * std::cos(std::numbers::pi * subdomain.nodes[n][2] / length);
    for (std::size_t i = 0; i < 3; ++i) {
      const double u = state.displacement.local()[3 * n + i];
      const double expected = i == component ? exact : 0;
      error += mass * (u - expected) * (u - expected);
      whole += mass * expected * expected;
    }
  }
  return std::sqrt(error / whole);
}

class PlaneWave : public ::testing::TestWithParam<int> {};

TEST_P(PlaneWave, ConvergesWithOrderTwoInSpace) {
  const char* name = GetParam() == 2 ? "P" : "S";
  std::vector<double> errors;
  for (const int cells : {12, 24, 48}) {
    errors.push_back(error_of_standing_wave(GetParam(), cells));
    std::printf("%s wave, %d cells in half a wave: error %.3e after a period", name, cells, errors.back());
    if (errors.size() > 1)
      std::printf(", order %.2f (reference 2)", std::log2(errors[errors.size() - 2] / errors.back()));
    std::printf("\n");
  }
  EXPECT_NEAR(std::log2(errors[1] / errors[2]), 2, 0.25);
  EXPECT_LT(errors[2], 5e-3);
}

INSTANTIATE_TEST_SUITE_P(Waves, PlaneWave, ::testing::Values(2, 0),
                         [](const auto& info) { return info.param == 2 ? "P" : "S"; });

}  // namespace
}  // namespace crackle::dynamics
