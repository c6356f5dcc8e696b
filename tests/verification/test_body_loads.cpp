// SPDX-License-Identifier: GPL-3.0-or-later
// Loads that vary in space and forces on the whole body, beside exact solutions.
#include "common/index.h"
#include "dynamics/energy_account.h"
#include "dynamics/quasi_static.h"
#include "dynamics/sample_run.h"
#include "parallel/agreement.h"

#include "support/box_mesh.h"
#include "support/job.h"
#include "support/plate_family.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BodyLoad;
using input::BoundaryKind;
using input::LoadKind;
using plane::Face;

/// A bar along z in SI. Without lateral contraction its stress is uniaxial, as in the exact solutions. It
/// rests on rollers, so that nothing hinders the sides.
struct Bar {
  explicit Bar(const Vector& size, std::array<int, 3> cells) {
    parameters = test::brittle(size, {3300e6, 0, 1180});
    for (const Face face : {Face::x_min, Face::y_min, Face::z_min}) {
      std::array<bool, 3> held{};
      held[index(plane::axis_of(face))] = true;
      parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, held));
    }
    subdomain = test::whole(test::make_box({.size = size, .cells = cells, .disturbance = 0.15}));
  }

  /// Leaves only the edge at the lower end on the rollers of the side, so that the bar can bend.
  void free_side() { parameters.boundaries[1].region[2] = {0, 0}; }

  mechanics::Conditions loads(const fracture::BreakableBody& body) const {
    auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
    mechanics::add_body_forces(self, parameters.body_forces(), subdomain, body.operators(), loads);
    return loads;
  }

  /// Calls `look` with the body, its loads and the equilibrium at time 0.
  template <class Look>
  void in_equilibrium(Look&& look) const {
    fracture::BreakableBody body(subdomain, parameters.materials[0]);
    const auto all = loads(body);
    auto law = test::tuler_butcher(parameters.fracture, subdomain);
    const QuasiStaticLoading loading(self, body, all, law, 1e-5);
    look(body, all, loading.displacement());
  }

  /// Mean displacement of the nodes at the end z-max.
  double end_displacement(std::size_t component) const {
    double sum = 0, n = 0;
    in_equilibrium([&](const auto&, const auto&, const parallel::NodeField& u) {
      for (std::size_t i = 0; i < subdomain.nodes.size(); ++i) {
        if (subdomain.nodes[i][2] != parameters.specimen.size[2]) continue;
        sum += u.local()[3 * i + component];
        ++n;
      }
    });
    return sum / n;
  }

  input::Parameters parameters;
  geometry::Subdomain subdomain;
  parallel::Communicator self{MPI_COMM_SELF};
};

BodyLoad gravity(double acceleration) {
  BodyLoad load;
  load.value = {0, 0, acceleration};
  return load;
}

TEST(BodyForce, StretchesAHangingBarByItsWeight) {
  const double length = 0.02, g = 9.81;
  for (const LoadKind kind : {LoadKind::acceleration, LoadKind::body_force}) {
    Bar bar({0.002, 0.003, length}, {2, 3, 20});
    const auto& material = bar.parameters.materials[0];
    BodyLoad load = gravity(kind == LoadKind::body_force ? g * material.density : g);
    load.kind = kind;
    bar.parameters.loads = {load};
    const double exact = material.density * g * length * length / (2 * material.youngs_modulus);
    const double found = bar.end_displacement(2);
    std::printf("%s: elongation %.6g m, exactly %.6g m (%.4f)\n", input::name_of(kind), found, exact,
                found / exact);
    EXPECT_NEAR(found / exact, 1, 0.005);
    // Its resultant is the weight, and its work twice the strain energy, rho^2 g^2 A L^3 / (6 E).
    const double area = 0.002 * 0.003, weight = material.density * g * area * length;
    bar.in_equilibrium(
        [&](const fracture::BreakableBody& body, const auto& loads, const parallel::NodeField& u) {
          ASSERT_EQ(loads.forces.size(), 1u);
          EXPECT_NEAR(loads.forces[0].amplitude.at(0) * loads.forces[0].resultant / weight, 1, 1e-12);
          const LoadState state = measure_loads(bar.self, body, loads, u, 0);
          const double strain = strain_energy(bar.self, body, u.local());
          const double energy =
              std::pow(material.density * g, 2) * area * std::pow(length, 3) / 6 / material.youngs_modulus;
          std::printf("  strain energy %.6g J, exactly %.6g J; half the work %.6g J\n", strain, energy,
                      strain_energy(state));
          EXPECT_NEAR(strain / energy, 1, 0.005);
          EXPECT_NEAR(strain_energy(state) / strain, 1, 1e-6);
          EXPECT_NEAR(state.conditions[2].reaction[2] / -weight, 1, 1e-6) << "the support carries the weight";
        });
  }
}

TEST(BodyForce, OfARotationStretchesABarAsItShould) {
  const double length = 0.02, speed = 3000;
  Bar bar({0.002, 0.002, length}, {2, 2, 24});
  const auto& material = bar.parameters.materials[0];
  BodyLoad load;
  load.kind = LoadKind::angular_velocity;
  load.angular_velocity = speed;
  load.axis = {-3, 0, 0};
  bar.parameters.loads = {load};
  // About an axis through its end, sigma = rho w^2 (L^2 - z^2) / 2.
  const double exact = material.density * speed * speed * std::pow(length, 3) / (3 * material.youngs_modulus);
  const double found = bar.end_displacement(2);
  double at_axis = 0, n = 0;
  bar.in_equilibrium(
      [&](const fracture::BreakableBody& body, const auto& loads, const parallel::NodeField& u) {
        ASSERT_EQ(loads.forces.size(), 2u) << "none along the axis";
        for (std::int32_t t = 0; t < body.subdomain().n_tetrahedra(); ++t) {
          double z = 0;
          for (const auto node : body.subdomain().tetrahedra[index(t)])
            z += body.subdomain().nodes[index(node)][2] / 4;
          if (z > 0.1 * length) continue;
          const double expected = material.density * speed * speed * (length * length - z * z) / 2;
          at_axis += body.stress(t, u.local())[2] / expected;
          ++n;
        }
      });
  std::printf(
      "rotating bar: elongation %.6g m, exactly %.6g m (%.4f); stress near the axis %.4f of the exact\n",
      found, exact, found / exact, at_axis / n);
  EXPECT_NEAR(found / exact, 1, 0.005);
  EXPECT_NEAR(at_axis / n, 1, 0.005);
}

TEST(BodyForce, ThatGrowsBreaksTheBarAtItsSupportAndSeparatesIt) {
  const double length = 0.02, area = 0.002 * 0.002;
  Bar bar({0.002, 0.002, length}, {3, 3, 20});
  auto& p = bar.parameters;
  p.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true})};
  p.time.precision = input::Precision::double_;
  BodyLoad load;
  load.rate = {0, 0, 1e5};
  p.loads = {load};
  const SampleResult result = run_sample(bar.self, p, p.output, bar.subdomain);
  const double weight = p.materials[0].density * area * length, critical = p.fracture.strength * area;
  std::printf(
      "%s after %zu breaks; onset at %.4g s under %.5g N, %.3f of strength times area; energy error %.1e\n",
      to_string(result.outcome).c_str(), result.breaks.size(), result.onset_time, result.onset_force,
      result.onset_force / critical, result.energy_error);
  EXPECT_EQ(result.outcome, Outcome::separated);
  // The load is the resultant of the body force.
  EXPECT_NEAR(result.onset_force / (weight * 1e5 * result.onset_time), 1, 1e-9);
  EXPECT_NEAR(result.onset_force / critical, 1, 0.15);
  EXPECT_LT(result.energy_error, 1e-5);
  ASSERT_FALSE(result.history.empty());
  EXPECT_EQ(result.history.back().force.size(), 2u) << "the support, and the body force";
}

TEST(BodyForce, ThatStartsSuddenlyDoesTheWorkInTheEnergyBalance) {
  for (const auto engine : {input::Engine::fixed_point, input::Engine::petsc}) {
    Bar bar({0.002, 0.002, 0.01}, {2, 2, 10});
    auto& p = bar.parameters;
    p.fracture.strength = 1e13;
    p.time.start = input::Start::rest;
    p.time.engine = engine;
    p.time.duration = 2e-5;
    p.time.precision = input::Precision::double_;
    BodyLoad pull = gravity(1e5), turn;
    pull.history = {{0, 1}, {5e-6, 3}, {1, 3}};
    turn.kind = LoadKind::angular_velocity;
    turn.angular_velocity = 2e3;
    turn.axis = {1, 0, 0};
    p.loads = {pull, turn};
    // Part of the body follows a drive, in which the load does no work.
    p.boundaries[2] = test::boundary(Face::z_min, BoundaryKind::velocity, {false, false, true}, {0, 0, 0.3});
    p.boundaries[2].factor = {1, {{0, 0.5}, {0.002, 1}}};
    const SampleResult result = run_sample(bar.self, p, p.output, bar.subdomain);
    double largest = 0;
    for (const auto& row : result.energy) largest = std::max(largest, row.kinetic);
    std::printf("%s: work %.4g J, kinetic up to %.4g J, energy error %.1e\n", to_string(engine),
                result.energy.back().external, largest, result.energy_error);
    EXPECT_GT(result.energy.back().external, 1e-6);
    EXPECT_LT(result.energy_error, 1e-5);
  }
}

TEST(BodyForce, LetsAFreeBodyFall) {
  Bar bar({0.002, 0.003, 0.004}, {2, 3, 4});
  auto& p = bar.parameters;
  p.boundaries.clear();
  p.time.start = input::Start::rest;
  p.time.duration = 1e-5;
  p.time.precision = input::Precision::double_;
  p.loads = {gravity(-1e6)};
  BodyLoad thrown;
  thrown.kind = LoadKind::velocity;
  thrown.value = {0, 0, 3};
  p.loads.push_back(thrown);
  const SampleResult result = run_sample(bar.self, p, p.output, bar.subdomain);
  const double mass = p.materials[0].density * 0.002 * 0.003 * 0.004;
  const auto& end = result.energy.back();
  const double speed = 3 - 1e6 * end.time, exact = 0.5 * mass * speed * speed;
  std::printf("thrown and falling: kinetic energy %.8g J at the start, %.8g J at the end, exactly %.8g J\n",
              result.energy.front().kinetic, end.kinetic, exact);
  EXPECT_NEAR(result.energy.front().kinetic / (0.5 * mass * 9), 1, 1e-9);
  EXPECT_NEAR(end.kinetic / exact, 1, 1e-8);
  EXPECT_LT(result.energy_error, 1e-8);
}

/// A thin ring whose points start outwards.
input::Parameters expanding_ring(const std::string& rate) {
  test::PlateText text;
  text.specimen = "thickness = \"1 mm\"\noutline = \"circle\"\nradius = \"10.5 mm\"";
  text.holes = {"center = [\"10.5 mm\", \"10.5 mm\"]\nradius = \"9.5 mm\""};
  text.mesh = "spacing = \"0.5 mm\"";
  text.boundaries = "[[load]]\nvelocity_gradient = [[\"0 1/s\", \"0 1/s\", \"0 1/s\"], [\"0 1/s\", \"" +
                    rate + "\", \"0 1/s\"], [\"0 1/s\", \"0 1/s\", \"" + rate +
                    "\"]]\ncenter = [\"0 mm\", \"10.5 mm\", \"10.5 mm\"]\n";
  std::string input = text.text();
  input.replace(input.find("[time]\n"), 7, "[time]\nstart = \"rest\"\nprecision = \"double\"\n");
  return input::parse(input, "ring.toml");
}

TEST(InitialVelocity, LetsARingBreathe) {
  auto parameters = expanding_ring("100 1/s");
  parameters.seed = 1;
  parameters.time.duration = 1.4e-5;
  parameters.output.history = 5e-8;
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto subdomain = test::whole(test::realization(parameters));
  const SampleResult result = run_sample(self, parameters, parameters.output, subdomain);
  ASSERT_TRUE(result.breaks.empty());
  // The kinetic energy of a ring between two circles.
  const double rho = parameters.materials[0].density, thickness = 1e-3, outer = 10.5e-3, inner = 9.5e-3;
  const double exact =
      0.25 * std::numbers::pi * rho * thickness * 1e4 * (std::pow(outer, 4) - std::pow(inner, 4));
  const double start = result.history.front().energy.kinetic;
  // It comes to rest after a quarter of a period.
  const auto least =
      std::ranges::min_element(result.history, {}, [](const HistoryRow& row) { return row.energy.kinetic; });
  ASSERT_NE(least, result.history.begin());
  ASSERT_NE(least + 1, result.history.end());
  const double before = (least - 1)->energy.kinetic, at = least->energy.kinetic,
               after = (least + 1)->energy.kinetic;
  const double interval = least->load_time - (least - 1)->load_time;
  const double quarter = least->load_time + interval * (before - after) / (2 * (before - 2 * at + after));
  const double frequency = std::sqrt(parameters.materials[0].youngs_modulus / rho) / 10e-3;
  const double found = 0.5 * std::numbers::pi / quarter;
  std::printf(
      "ring of %d nodes: kinetic energy %.6g J, of exact circles %.6g J (%.4f); %.3g of it left at rest; "
      "breathes at "
      "%.6g rad/s, thin ring %.6g rad/s (%.4f); energy error %.1e\n",
      static_cast<int>(subdomain.nodes.size()), start, exact, start / exact, at / start, found, frequency,
      found / frequency, result.energy_error);
  EXPECT_NEAR(start / exact, 1, 0.01);
  EXPECT_NEAR(result.history.front().energy.external / start, 1, 1e-9) << "given to the body";
  EXPECT_LT(at / start, 0.01);
  EXPECT_NEAR(found / frequency, 1, 0.015);
  EXPECT_LT(result.energy_error, 1e-5);
}

/// Moment about x of the forces of all patterns, about the middle of the width [N m].
double moment(const Bar& bar, const mechanics::Conditions& loads) {
  double sum = 0;
  for (const auto& pattern : loads.forces)
    for (std::size_t i = 0; i < pattern.nodes.size(); ++i)
      sum += (bar.subdomain.nodes[index(pattern.nodes[i])][1] - bar.parameters.specimen.size[1] / 2) *
             pattern.amplitude.at(0) * pattern.weight[i];
  return sum;
}

TEST(Factor, ThatIsLinearBendsAStrip) {
  const double height = 0.004, width = 0.002, length = 0.02, sigma = 1e6;
  Bar strip({width, height, length}, {2, 16, 60});
  strip.free_side();
  auto pull = test::boundary(Face::z_max, BoundaryKind::traction, {}, {0, 0, sigma});
  pull.factor = {1, {{0, -1}, {height, 1}}};
  strip.parameters.boundaries.push_back(pull);
  const double exact_moment = sigma * width * height * height / 6;
  strip.in_equilibrium([&](const fracture::BreakableBody&, const auto& loads, const parallel::NodeField& u) {
    EXPECT_NEAR(loads.forces[0].resultant, 0, 1e-12 * width * height);
    const double m = moment(strip, loads);
    // The end turns by M L / (E I).
    double slope = 0, squares = 0;
    for (std::size_t i = 0; i < strip.subdomain.nodes.size(); ++i) {
      const auto& p = strip.subdomain.nodes[i];
      if (p[2] != length) continue;
      slope += u.local()[3 * i + 2] * (p[1] - height / 2);
      squares += std::pow(p[1] - height / 2, 2);
    }
    const double turn = 2 * sigma * length / (strip.parameters.materials[0].youngs_modulus * height);
    std::printf("strip: moment %.8g N m, exactly %.8g N m; end turns by %.5g, exactly %.5g (%.3f)\n", m,
                exact_moment, slope / squares, turn, slope / squares / turn);
    EXPECT_NEAR(m / exact_moment, 1, 1e-12);
    EXPECT_NEAR(slope / squares / turn, 1, 0.05);
  });
}

TEST(Factor, IsIntegratedExactlyWhereItHasKinks) {
  const double height = 0.004, width = 0.002;
  Bar strip({width, height, 0.004}, {3, 5, 4});
  strip.parameters.boundaries.emplace_back();
  const fracture::BreakableBody body(strip.subdomain, strip.parameters.materials[0]);
  // A hat of full height 1 over a third of the face, with kinks inside triangles.
  const input::Profile hat{1, {{0.0009, 0}, {0.0013, 1}, {0.0021, 1}, {0.0022, 0}}};
  const double area = width * (0.0008 + 0.5 * (0.0004 + 0.0001));
  const auto with = [&](BoundaryKind kind, Vector value, const input::Profile& factor) {
    auto load = test::boundary(Face::z_max, kind, {}, value);
    load.factor = factor;
    strip.parameters.boundaries.back() = load;
    return strip.loads(body);
  };
  const auto traction = with(BoundaryKind::traction, {0, 0, 1}, hat);
  std::printf("area of a hat %.10g m^2, exactly %.10g m^2\n", traction.forces[0].resultant, area);
  EXPECT_NEAR(traction.forces[0].resultant / area, 1, 1e-12);
  const auto pressure = with(BoundaryKind::pressure, {1, 0, 0}, hat);
  ASSERT_EQ(pressure.forces.size(), 1u);
  EXPECT_NEAR(pressure.forces[0].resultant / -area, 1, 1e-12);
  // A force keeps its total; the factor's scale does not matter.
  input::Profile doubled = hat;
  for (auto& [at, factor] : doubled.table) factor *= -2;
  for (const auto& factor : {hat, doubled}) {
    const auto force = with(BoundaryKind::force, {0, 0, 10}, factor);
    double sum = 0;
    for (std::size_t i = 0; i < force.forces[0].nodes.size(); ++i) {
      sum += force.forces[0].weight[i];
      EXPECT_NEAR(force.forces[0].weight[i], traction.forces[0].weight[i] / area, 1e-9);
    }
    EXPECT_NEAR(sum, 1, 1e-12);
  }
  const input::Profile odd{1, {{0, -1}, {height, 1}}}, zero{1, {{0.5, 0}}},
      beside{1, {{0.006, 0}, {0.007, 1}}};
  EXPECT_THROW(with(BoundaryKind::force, {0, 0, 10}, odd), parallel::AgreedError) << "it has no resultant";
  EXPECT_THROW(with(BoundaryKind::traction, {0, 0, 1}, zero), parallel::AgreedError);
  EXPECT_THROW(with(BoundaryKind::pressure, {1, 0, 0}, beside), parallel::AgreedError);
}

/// The end of a strip is turned: its reaction is a moment, not a force.
TEST(Factor, OfADisplacementTurnsAnEndAndDoesItsWork) {
  const double height = 0.004, length = 0.02, end = 1e-5;
  Bar strip({0.002, height, length}, {2, 16, 60});
  strip.free_side();
  auto turn = test::boundary(Face::z_max, BoundaryKind::displacement, {false, false, true}, {0, 0, end});
  turn.factor = {1, {{0, -1}, {height, 1}}};
  strip.parameters.boundaries.push_back(turn);
  strip.in_equilibrium([&](const fracture::BreakableBody& body, const auto& loads,
                           const parallel::NodeField& u) {
    const LoadState state = measure_loads(strip.self, body, loads, u, 0);
    const double strain = strain_energy(strip.self, body, u.local());
    const Work& turning = state.works[loads.forces.size() + 3];
    // Stress E u / L at the edges; energy sigma^2 / (6 E) per volume.
    const double exact = strip.parameters.materials[0].youngs_modulus * std::pow(end / length, 2) / 6 *
                         0.002 * height * length;
    std::printf(
        "turned end: strain energy %.5g J, exactly %.5g J (%.3f), half the work %.5g J; reaction %.2g N\n",
        strain, exact, strain / exact, 0.5 * turning.force * turning.displacement,
        state.conditions[3].reaction[2]);
    EXPECT_NEAR(strain / exact, 1, 0.05);
    EXPECT_NEAR(0.5 * turning.force * turning.displacement / strain, 1, 1e-6);
    EXPECT_LT(std::abs(state.conditions[3].reaction[2]), 0.01 * turning.force);
  });
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
