// SPDX-License-Identifier: GPL-3.0-or-later
// Rigid tools against exact solutions: impact on a bar, compression, sliding, and a sphere pressed into a
// block.
#include "common/index.h"
#include "dynamics/sample_run.h"

#include "support/box_mesh.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using input::Tool;
using input::ToolShape;
using plane::Face;

/// A bar without lateral contraction that does not break.
input::Parameters strong_bar(const Vector& size) {
  auto parameters = test::brittle(size);
  parameters.materials[0].poisson_ratio = 0;
  parameters.fracture.strength = 1e10;
  parameters.boundaries.clear();
  return parameters;
}

SampleResult run(const input::Parameters& parameters, const geometry::Realization& mesh) {
  return run_sample(parallel::Communicator(MPI_COMM_SELF), parameters, parameters.output, test::whole(mesh),
                    SampleControl{});
}

Tool plate_at(double z, double direction) {
  Tool tool;
  tool.shape = ToolShape::plane;
  tool.at = {0, 0, z};
  tool.axis = {0, 0, direction};
  return tool;
}

class Impact : public testing::TestWithParam<input::Integrator> {};

TEST_P(Impact, OfAMassOnABarFollowsTheExactDecay) {
  // As long as nothing comes back from the far end, the force is rho c A v exp(-rho c A t / m).
  const double length = 0.08, side = 0.002, mass = 4e-4, speed = 2;
  auto parameters = strong_bar({side, side, length});
  const auto& material = parameters.materials[0];
  const double wave = std::sqrt(material.youngs_modulus / material.density);
  const double impedance = material.density * wave * side * side;
  parameters.time.start = input::Start::rest;
  parameters.time.integrator = GetParam();
  parameters.time.duration = 1.9 * length / wave;
  auto tool = plate_at(length + 1e-6, -1);
  tool.mass = mass;
  tool.velocity = Vector{0, 0, -speed};
  parameters.tools = {tool};
  const auto result = run(parameters, test::make_box({.size = {side, side, length}, .cells = {2, 2, 80}}));
  const double start = 1e-6 / speed;
  double worst = 0;
  for (const HistoryRow& row : result.history) {
    const double exact =
        row.load_time < start ? 0 : speed * std::exp(-impedance * (row.load_time - start) / mass);
    const double own = -row.tools.at(0).velocity[2];
    if (row.load_time > start) worst = std::max(worst, std::abs(own - exact) / speed);
  }
  const HistoryRow& end = result.history.back();
  const double left =
      0.5 * mass * std::pow(end.tools[0].velocity[2], 2) + end.energy.kinetic + end.energy.strain;
  const double whole = 0.5 * mass * speed * speed;
  std::printf("velocity of the mass within %.2g of the exact decay; energy %.8g of %.8g J, error %.1e\n",
              worst, left, whole, result.energy_error);
  EXPECT_LT(worst, 0.02);
  EXPECT_NEAR(left / whole, 1, 0.01);
  EXPECT_LT(result.energy_error, 0.01);
  EXPECT_GT(std::abs(end.tools[0].velocity[2]), 0.1 * speed);
}

INSTANTIATE_TEST_SUITE_P(Integrators, Impact,
                         testing::Values(input::Integrator::bilateral4, input::Integrator::verlet));

/// A block between two plates of which one is pressed, by a displacement or by a force.
SampleResult pressed_block(const Tool& drive) {
  auto parameters = strong_bar({0.004, 0.004, 0.008});
  parameters.boundaries = {test::boundary(Face::x_min, BoundaryKind::fix, {true, false, false}),
                           test::boundary(Face::y_min, BoundaryKind::fix, {false, true, false})};
  parameters.tools = {plate_at(0, 1), drive};
  return run(parameters,
             test::make_box({.size = {0.004, 0.004, 0.008}, .cells = {4, 4, 8}, .disturbance = 0.2}));
}

TEST(Tools, CompressABlockAsAForceAndAsADisplacement) {
  const double area = 0.004 * 0.004, modulus = test::epoxy().youngs_modulus, length = 0.008;
  auto pusher = plate_at(length, -1);
  pusher.displacement = Vector{0, 0, -1e-5};
  pusher.history = {{0, 0}, {1, 1}};
  const auto by_displacement = pressed_block(pusher);
  const ToolState& driven = by_displacement.history.back().tools.at(1);
  const double exact = -modulus * area / length * 1e-5;

  pusher.displacement.reset();
  pusher.force = driven.reaction;
  const auto by_force = pressed_block(pusher);
  const ToolState& loaded = by_force.history.back().tools.at(1);
  std::printf(
      "%.6g N at 10 um, exactly %.6g N; the same force moves the plate by %.8g um; energy errors %.1e, "
      "%.1e\n",
      driven.reaction[2], exact, -1e6 * loaded.displacement[2], by_displacement.energy_error,
      by_force.energy_error);
  // Two contacts give way by what their stiffness says, each as half a spacing of the body.
  EXPECT_NEAR(driven.reaction[2] / exact, 1, 0.15);
  EXPECT_NEAR(loaded.displacement[2] / -1e-5, 1, 1e-6);
  EXPECT_NEAR(loaded.reaction[2] / driven.reaction[2], 1, 1e-6);
  EXPECT_NEAR(by_force.history.back().tools[0].reaction[2] / -driven.reaction[2], 1, 1e-6);
  EXPECT_LT(by_displacement.energy_error, 1e-3);
  EXPECT_LT(by_force.energy_error, 1e-3);
}

TEST(Tools, SlowASlidingBlockByCoulombsLaw) {
  // Pressed on a plate by its weight, a block that slides at first slows down by mu g, and then sticks.
  const double g = 1e6, friction = 0.3, speed = 8;
  for (const bool slides : {true, false}) {
    auto parameters = strong_bar({0.004, 0.004, 0.002});
    parameters.time.start = input::Start::rest;
    parameters.time.integrator = input::Integrator::verlet;
    parameters.time.duration = 2.4e-5;
    auto plate = plate_at(0, 1);
    plate.friction = friction;
    parameters.tools = {plate};
    input::BodyLoad weight;
    weight.kind = input::LoadKind::acceleration;
    // A slope, across which the weight is g.
    weight.value = {0, slides ? 0 : 0.25 * g, -g};
    weight.history = {{0, 0}, {1.2e-5, 1}};
    parameters.loads = {weight};
    if (slides) {
      input::BodyLoad start;
      start.kind = input::LoadKind::velocity;
      start.value = {0, speed, 0};
      parameters.loads.push_back(start);
    }
    parameters.output.probes = {{"middle", {0.002, 0.002, 0.001}}};
    const auto result = run(parameters, test::make_box({.size = {0.004, 0.004, 0.002}, .cells = {4, 4, 2}}));
    const HistoryRow& end = result.history.back();
    const double mass = test::epoxy().density * 0.004 * 0.004 * 0.002;
    // The weight grows to g in 12 us.
    const double lost = friction * g * (end.energy.time - 6e-6);
    std::printf(
        "%s: y velocity %.4g m/s, by Coulomb's law %.4g; lost to friction %.4g uJ, energy error %.1e\n",
        slides ? "slides" : "sticks", end.probes.at(0).velocity[1], slides ? speed - lost : 0.0,
        1e6 * end.tools.at(0).friction_work, result.energy_error);
    if (slides) {
      EXPECT_LT(result.energy_error, 1e-3);
      EXPECT_NEAR(end.probes[0].velocity[1], speed - lost, 0.03 * lost);
      const double work = 0.5 * mass * (speed * speed - std::pow(speed - lost, 2));
      EXPECT_NEAR(end.tools[0].friction_work / work, 1, 0.01);
    } else {
      EXPECT_LT(result.energy_error, 1e-3);
      EXPECT_LT(std::abs(end.probes[0].velocity[1]), 0.05 * lost);
    }
  }
}

TEST(Tools, DragABlockAcrossAPlateInEquilibrium) {
  // The upper plate holds the block by friction and moves down and along; below it slides.
  auto parameters = strong_bar({0.008, 0.008, 0.004});
  parameters.materials[0].poisson_ratio = 0.3;
  auto base = plate_at(0, 1), drive = plate_at(0.004, -1);
  base.friction = 0.3;
  drive.friction = 2;
  drive.displacement = Vector{0, 6e-5, -1e-5};
  drive.history = {{0, 0}, {1, 1}};
  parameters.tools = {base, drive};
  const auto result = run(
      parameters, test::make_box({.size = {0.008, 0.008, 0.004}, .cells = {6, 6, 3}, .disturbance = 0.2}));
  const ToolState& below = result.history.back().tools.at(0);
  std::printf("friction over pressure %.6f, exactly 0.3; %lld solves, residual %.1e, energy error %.1e\n",
              std::hypot(below.reaction[0], below.reaction[1]) / below.reaction[2],
              static_cast<long long>(result.counts.static_solves), result.equilibrium_residual,
              result.energy_error);
  EXPECT_NEAR(-below.reaction[1] / below.reaction[2], 0.3, 0.003);
  EXPECT_LT(result.equilibrium_residual, 1e-7);
  EXPECT_LT(result.counts.static_solves, 60);
  EXPECT_LT(result.energy_error, 1e-2);
}

/// A beam on three rollers, which are tools or lines of nodes.
SampleResult bent_beam(bool on_tools) {
  const double height = 0.004, middle = 0.012, deflection = 2e-5;
  auto parameters = strong_bar({0.002, height, 2 * middle});
  parameters.materials[0].poisson_ratio = 0.3;
  parameters.boundaries = {test::boundary(Face::x_min, BoundaryKind::fix, {true, false, false})};
  const std::array<std::pair<double, double>, 3> rollers{{{0, 0.002}, {0, 0.022}, {height, middle}}};
  for (const auto& [y, z] : rollers) {
    const bool moves = y > 0;
    if (on_tools) {
      Tool roller;
      roller.shape = ToolShape::cylinder;
      roller.radius = 0.002;
      roller.axis = {1, 0, 0};
      roller.at = {0.001, y + (moves ? 1 : -1) * roller.radius, z};
      if (moves) roller.friction = 0.3;  // so that the beam stays in place
      if (moves) {
        roller.displacement = Vector{0, -deflection, 0};
        roller.history = {{0, 0}, {1, 1}};
      }
      parameters.tools.push_back(roller);
    } else {
      auto line = test::boundary(moves ? Face::y_max : Face::y_min,
                                 moves ? BoundaryKind::displacement : BoundaryKind::fix,
                                 {false, true, z == rollers[0].second}, {0, moves ? -deflection : 0, 0});
      line.region[2] = {z, z};
      if (moves) line.history = {{0, 0}, {1, 1}};
      parameters.boundaries.push_back(line);
    }
  }
  return run(parameters, test::make_box({.size = {0.002, height, 2 * middle}, .cells = {4, 8, 48}}));
}

TEST(Tools, BendABeamAsLinesOfNodesDo) {
  const auto by_tools = bent_beam(true), by_lines = bent_beam(false);
  const double load = by_tools.history.back().tools.at(2).reaction[1],
               of_lines = by_lines.history.back().force.at(3)[1];
  std::printf("%.5g N by rollers, %.5g N by lines of nodes; %lld solves, residual %.1e, energy error %.1e\n",
              load, of_lines, static_cast<long long>(by_tools.counts.static_solves),
              by_tools.equilibrium_residual, by_tools.energy_error);
  EXPECT_NEAR(load / of_lines, 1, 0.02);
  EXPECT_LT(by_tools.counts.static_solves, 60);
  EXPECT_LT(by_tools.energy_error, 1e-2);
}

TEST(Tools, ThatOverlapTheBodyAreRefused) {
  auto parameters = strong_bar({0.004, 0.004, 0.008});
  parameters.time.start = input::Start::rest;
  auto tool = plate_at(0.007, -1);
  tool.name = "platen";
  parameters.tools = {tool};
  EXPECT_THAT(
      [&] {
        run(parameters, test::make_box({.size = {0.004, 0.004, 0.008}, .cells = {2, 2, 4}}));
      },
      testing::ThrowsMessage<std::runtime_error>(
          testing::HasSubstr("tool \"platen\" overlaps the body by 1 mm at the start")));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
