// SPDX-License-Identifier: GPL-3.0-or-later
// Rigid tools against exact solutions: impact on a bar, compression, sliding, turning, and a sphere pressed
// into a block.
#include "common/index.h"
#include "dynamics/rigid_turning.h"
#include "dynamics/sample_run.h"
#include "dynamics/tool_shape.h"

#include "support/box_mesh.h"

#include <gmock/gmock.h>
#include <boost/math/special_functions/jacobi_elliptic.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
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

TEST(Tools, ThatNeverTouchTheBodyAreNoted) {
  const auto thrown = [](double speed) {
    auto parameters = strong_bar({0.002, 0.002, 0.01});
    parameters.time.start = input::Start::rest;
    parameters.time.duration = 2e-5;
    auto tool = plate_at(0.01 + 1e-6, -1);
    tool.name = "ball";
    tool.mass = 4e-4;
    tool.velocity = Vector{0, 0, speed};
    parameters.tools = {tool};
    return run(parameters, test::make_box({.size = {0.002, 0.002, 0.01}, .cells = {2, 2, 10}})).note;
  };
  EXPECT_EQ(thrown(2), "ball never touched the body");
  EXPECT_EQ(thrown(-2), "");
}

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

/// The top of a cube is driven along x, and a platen presses it with friction: what drives it bears both.
TEST(Tools, WhatDrivesANodeBearsTheToolThere) {
  constexpr double side = 0.004, travel = 2e-5;
  auto parameters = strong_bar({side, side, side});
  parameters.materials[0].poisson_ratio = 0.3;
  auto top = test::boundary(Face::z_max, BoundaryKind::displacement, {true, false, false});
  top.value = {travel, 0, 0};
  top.history = {{0, 0}, {1, 1}};
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}), top};
  auto platen = plate_at(side, -1);
  platen.friction = 0.3;
  platen.displacement = Vector{0, 0, -travel};
  platen.history = {{0, 0}, {1, 1}};
  parameters.tools = {platen};
  const auto result =
      run(parameters, test::make_box({.size = {side, side, side}, .cells = {5, 5, 5}, .disturbance = 0.2}));
  const HistoryRow& end = result.history.back();
  const double sum = end.force.at(0)[0] + end.force.at(1)[0] + end.tools.at(0).reaction[0];
  std::printf("forces along x: base %.6g N, drive %.6g N, platen %.6g N; sum %.1e N; energy error %.1e\n",
              end.force[0][0], end.force[1][0], end.tools[0].reaction[0], sum, result.energy_error);
  EXPECT_GT(std::abs(end.tools[0].reaction[0]), 10);
  EXPECT_NEAR(sum, 0, 1e-6 * std::abs(end.force[1][0]));
  EXPECT_LT(result.energy_error, 1e-6);
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

constexpr std::array<bool, 6> all_ways{true, true, true, true, true, true};

double moment_about(const Tool& tool, int axis) {
  return moment_of_inertia(tool)(axis, axis);
}

/// The energy of a tool's motion [J].
double kinetic_energy(const Tool& tool, const ToolState& now) {
  const auto& [w, x, y, z] = now.orientation;
  const Vector spin = turned(Eigen::Quaterniond(w, -x, -y, -z), now.angular_velocity);
  const Eigen::Vector3d own(spin.data());
  return 0.5 * tool.mass * dot(now.velocity, now.velocity) + 0.5 * own.dot(moment_of_inertia(tool) * own);
}

Tool box_of(const std::vector<double>& size, double mass) {
  Tool box;
  box.shape = ToolShape::box;
  box.size = size;
  box.mass = mass;
  box.free = all_ways;
  return box;
}

TEST(ToolShapes, HaveTheInertiaOfTheirVolume) {
  // Counted on a grid; a body that is all rounding is a sphere.
  auto box = box_of({0.006, 0.004, 0.003}, 2.0), cylinder = box;
  box.rounding = 0.001;
  cylinder.shape = ToolShape::cylinder;
  cylinder.axis = {0, 2, 0};
  cylinder.size = {0.006};
  cylinder.radius = 0.002;
  cylinder.rounding = 0.0015;
  for (const Tool& tool : {box, cylinder}) {
    constexpr int n = 120;
    Vector square{};
    double inside = 0;
    for (int i = 0; i < n * n * n; ++i) {
      const Vector p{0.006 * ((i % n + 0.5) / n - 0.5), 0.006 * ((i / n % n + 0.5) / n - 0.5),
                     0.006 * ((i / n / n + 0.5) / n - 0.5)};
      if (surface_from(tool, p).distance > 0) continue;
      inside += 1;
      for (std::size_t k = 0; k < 3; ++k) square[k] += p[k] * p[k];
    }
    for (int k = 0; k < 3; ++k) {
      const double counted = 2.0 * (square[index((k + 1) % 3)] + square[index((k + 2) % 3)]) / inside;
      EXPECT_NEAR(moment_about(tool, k) / counted, 1, 2e-3) << k;
    }
  }
  const double ball = 0.4 * 2.0 * 0.001 * 0.001;
  box.size = {0.002, 0.002, 0.002};
  cylinder.size = {0.002};
  cylinder.radius = cylinder.rounding = 0.001;
  EXPECT_NEAR(moment_about(box, 0) / ball, 1, 1e-12);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(moment_about(cylinder, k) / ball, 1, 1e-12);
}

/// How far a free box that spins is from the exact solution, by Jacobi's elliptic functions: with a spin at
/// the start in the plane of its first and third axes.
struct SpinErrors {
  double modulus = 0, spin = 0, energy = 0, momentum = 0;  // all but the first relative
  double least = 0, most = 0;                              // spin about the middle axis, likewise
};

SpinErrors errors_of_spin(const Vector& start, double step) {
  const Vector size{0.006, 0.004, 0.002};
  auto box = box_of({size[0], size[1], size[2]}, 1e-3);
  box.at = {0.1, 0, 0};
  box.angular_velocity = start;
  auto parameters = strong_bar({0.002, 0.002, 0.002});
  parameters.time.start = input::Start::rest;
  parameters.time.duration = 5e-4;
  parameters.time.step = step;
  parameters.tools = {box};
  const auto result = run(parameters, test::make_box({.size = {0.002, 0.002, 0.002}, .cells = {2, 2, 2}}));
  EXPECT_EQ(result.energy.back().external, 0);
  const Eigen::Vector3d inertia = moment_of_inertia(box).diagonal();
  const Eigen::Vector3d momentum = inertia.cwiseProduct(Eigen::Vector3d(start.data()));
  const double energy = kinetic_energy(box, result.history.front().tools.at(0));
  // The axis that the spin circles counts as the third.
  const std::size_t third = momentum.squaredNorm() < 2 * energy * inertia[1] ? 0 : 2, first = 2 - third;
  const double a = inertia[static_cast<Eigen::Index>(first)], b = inertia[1],
               c = inertia[static_cast<Eigen::Index>(third)];
  const double across = a * (c - a) * std::pow(start[first], 2),
               along = c * (c - a) * std::pow(start[third], 2);
  SpinErrors errors{.modulus = std::sqrt((b - a) * across / ((c - b) * along))};
  const double rate = std::sqrt((c - b) * along / (a * b * c));
  for (const HistoryRow& row : result.history) {
    const ToolState& now = row.tools.at(0);
    const auto& [w, x, y, z] = now.orientation;
    const Eigen::Quaterniond orientation(w, x, y, z);
    const Vector spin = turned(orientation.conjugate(), now.angular_velocity);
    double cosine = 0, delta = 0;
    const double sine = boost::math::jacobi_elliptic(errors.modulus, rate * row.load_time, &cosine, &delta);
    Vector exact{0, std::sqrt(across / (b * (c - b))) * sine, 0};
    exact[first] = start[first] * cosine;
    exact[third] = start[third] * delta;
    errors.spin = std::max(errors.spin, norm(spin - exact) / norm(start));
    errors.energy = std::max(errors.energy, std::abs(kinetic_energy(box, now) / energy - 1));
    const Eigen::Vector3d own = inertia.cwiseProduct(Eigen::Vector3d(spin.data()));
    errors.momentum = std::max(errors.momentum, (orientation * own - momentum).norm() / momentum.norm());
    errors.least = std::min(errors.least, spin[1] / norm(start));
    errors.most = std::max(errors.most, spin[1] / norm(start));
  }
  return errors;
}

TEST(Tools, SpinAsEulersEquationsSay) {
  // About the third and the first axis it is stable; about the middle one the spin goes over to the other
  // sense.
  for (const Vector& start : {Vector{5e3, 0, 1e5}, Vector{1e5, 0, 5e3}, Vector{1.2477e5, 0, 1e5}}) {
    const SpinErrors coarse = errors_of_spin(start, 6e-8), fine = errors_of_spin(start, 3e-8);
    std::printf(
        "from (%g, 0, %g) rad/s, modulus %.6f: spin within %.1e and %.1e of the exact one, energy %.1e, "
        "angular "
        "momentum %.1e, about the middle axis %.3f to %.3f\n",
        start[0], start[2], fine.modulus, coarse.spin, fine.spin, fine.energy, fine.momentum, fine.least,
        fine.most);
    EXPECT_LT(fine.spin, 0.01);
    EXPECT_NEAR(coarse.spin / fine.spin, 4, 0.4);
    EXPECT_LT(fine.energy, 1e-6);
    EXPECT_LT(fine.momentum, 1e-12);
    const bool is_near_middle = fine.modulus > 0.99;
    EXPECT_EQ(fine.most > 0.9, is_near_middle);
    EXPECT_EQ(fine.least < -0.9, is_near_middle);
  }
}

TEST(Tools, RollDownASlopeUntilFrictionFails) {
  // A sphere under its weight, on a slope of 30 degrees: rolls at 5/7 g sin alpha, and slips where tan alpha
  // exceeds 7/2 of the friction, here 0.165. The weight grows within 0.6 ms.
  const double radius = 0.01, weight = 80, alpha = std::numbers::pi / 6, ramp = 6e-4;
  for (const double friction : {0.5, 0.2, 0.13, 0.05}) {
    auto parameters = strong_bar({0.004, 0.016, 0.002});
    parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true})};
    parameters.time.start = input::Start::rest;
    parameters.time.integrator = input::Integrator::verlet;
    parameters.time.duration = 3e-3;
    Tool ball;
    ball.radius = radius;
    ball.at = {0.002, 0.004, 0.002 + radius};
    ball.mass = 0.0327;
    ball.force = Vector{0, weight * std::sin(alpha), -weight * std::cos(alpha)};
    ball.history = {{0, 0}, {ramp, 1}};
    ball.friction = friction;
    ball.free = all_ways;
    parameters.tools = {ball};
    const auto result = run(parameters, test::make_box({.size = {0.004, 0.016, 0.002}, .cells = {4, 16, 2}}));
    const HistoryRow& end = result.history.back();
    const ToolState& now = end.tools.at(0);
    const double g_time = weight / ball.mass * (end.load_time - 0.5 * ramp);
    const bool slips = std::tan(alpha) > 3.5 * friction;
    const double speed =
        (slips ? std::sin(alpha) - friction * std::cos(alpha) : 5.0 / 7 * std::sin(alpha)) * g_time;
    const double turning = slips ? 2.5 * friction * std::cos(alpha) * g_time : speed;
    double supplied = 0;
    for (std::size_t i = 1; i < result.history.size(); ++i) {
      const HistoryRow &before = result.history[i - 1], &after = result.history[i];
      const double middle = 0.5 * (before.load_time + after.load_time);
      supplied += std::min(1.0, middle / ramp) *
                  dot(*ball.force, after.tools[0].displacement - before.tools[0].displacement);
    }
    const double error = (kinetic_energy(ball, now) + end.energy.external) / supplied - 1;
    std::printf(
        "friction %.2f %s: %.4f m/s, exactly %.4f; turns at %.4f m/s, exactly %.4f; energy %.1e, of the body "
        "%.1e\n",
        friction, slips ? "slips" : "rolls", now.velocity[1], speed, -radius * now.angular_velocity[0],
        turning, error, result.energy_error);
    EXPECT_NEAR(now.velocity[1] / speed, 1, 0.02);
    EXPECT_NEAR(-radius * now.angular_velocity[0] / turning, 1, 0.05);
    EXPECT_LT(std::abs(error), 3e-3);
    EXPECT_LT(result.energy_error, 0.01);
  }
}

TEST(Tools, HitOffTheirCentreAsRigidBodiesDo) {
  // A box falls flat onto a post at a distance d from its centre. The post gives way by far less than d, and
  // waves cross it a hundred times during the impact, so that it gives all energy back: the impulse is 2 v /
  // (1/m + d^2/I).
  const double distance = 0.006, speed = 0.1;
  for (const bool turns : {true, false}) {
    auto parameters = strong_bar({0.002, 0.002, 0.004});
    parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true})};
    parameters.time.start = input::Start::rest;
    parameters.time.duration = 6e-4;
    auto box = box_of({0.02, 0.02, 0.01}, 0.05);
    box.at = {0.001, 0.001 - distance, 0.004 + 1e-6 + 0.005};
    box.velocity = Vector{0, 0, -speed};
    if (!turns) box.free = {true, true, true, false, true, true};
    parameters.tools = {box};
    const auto result = run(parameters, test::make_box({.size = {0.002, 0.002, 0.004}, .cells = {2, 2, 4}}));
    const HistoryRow& end = result.history.back();
    const ToolState& now = end.tools.at(0);
    const double inertia = moment_about(box, 0);
    const double impulse = 2 * speed / (1 / box.mass + (turns ? distance * distance / inertia : 0));
    const double velocity = impulse / box.mass - speed, spin = turns ? impulse * distance / inertia : 0;
    const double energy = kinetic_energy(box, now) / (0.5 * box.mass * speed * speed);
    std::printf(
        "%s: velocity %.5f m/s, exactly %.5f; spin %.4f rad/s, exactly %.4f; energy left %.5f; error %.1e\n",
        turns ? "turns" : "does not turn", now.velocity[2], velocity, now.angular_velocity[0], spin, energy,
        result.energy_error);
    EXPECT_NEAR(now.velocity[2], velocity, 0.02 * speed);
    EXPECT_NEAR(now.angular_velocity[0], spin, 0.02 * impulse * distance / inertia);
    EXPECT_NEAR(energy, 1, 0.01);
    EXPECT_EQ(now.reaction, Vector{});
  }
}

TEST(Tools, OfLittleInertiaHaveASofterContact) {
  // A corner of a light lath on a post is seven times as light as its middle.
  auto parameters = strong_bar({0.002, 0.002, 0.004});
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true})};
  parameters.time.start = input::Start::rest;
  parameters.time.integrator = input::Integrator::verlet;
  parameters.time.duration = 4e-5;
  auto lath = box_of({0.003, 0.02, 0.0002}, 1e-7);
  lath.at = {0.001, 0.011, 0.0041 + 1e-6};
  lath.velocity = Vector{0, 0, -2};
  lath.friction = 0.5;
  parameters.tools = {lath};
  const auto result = run(parameters, test::make_box({.size = {0.002, 0.002, 0.004}, .cells = {2, 2, 4}}));
  const HistoryRow& end = result.history.back();
  const double whole = kinetic_energy(lath, result.history.front().tools.at(0));
  const double left = kinetic_energy(lath, end.tools.at(0)) + end.energy.kinetic + end.energy.strain;
  std::printf(
      "mass of the corner %.3f of the whole; energy left %.5f, lost by friction %.5f, of the body's work "
      "%.1e\n",
      least_mass(lath) / lath.mass, left / whole, end.energy.dissipated / whole, result.energy_error);
  EXPECT_GT(end.tools.at(0).velocity[2], -1.9);
  EXPECT_NEAR((left + end.energy.dissipated) / whole, 1, 0.02);
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
