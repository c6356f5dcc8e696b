// SPDX-License-Identifier: GPL-3.0-or-later
// Boundary conditions in dynamics: motions of part of a face, loads with a history, free flight.
#include "common/real.h"
#include "dynamics/sample_run.h"
#include "mechanics/conditions.h"
#include "mechanics/rigid_motion.h"
#include "parallel/exact_sum.h"

#include "support/elastic_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

constexpr geometry::Point size{0.003, 0.004, 0.008};

input::Parameters epoxy_with(std::vector<input::Boundary> boundaries) {
  input::Parameters parameters;
  parameters.specimen.size = size;
  parameters.materials[0] = test::epoxy();
  parameters.boundaries = std::move(boundaries);
  return parameters;
}

/// A small epoxy block with a boundary list.
class Block : public test::ElasticMotion {
public:
  explicit Block(std::vector<input::Boundary> boundaries)
      : ElasticMotion(test::make_box({.size = size, .cells = {3, 4, 8}, .disturbance = 0.2}),
                      epoxy_with(std::move(boundaries))) {}

  double step() const { return 0.5 * stable_step(); }
  void move(std::int64_t n_steps) {
    start(static_cast<double>(n_steps) * step());
    advance(n_steps, step());
  }

  Vector momentum() const {
    return sum_over_nodes([&](std::size_t n) { return times_mass(n, velocity_of(n)); });
  }
  /// About the origin, with the undeformed positions, as exactly conserved by linear elasticity.
  Vector angular_momentum() const {
    return sum_over_nodes(
        [&](std::size_t n) { return times_mass(n, cross(subdomain().nodes[n], velocity_of(n))); });
  }

private:
  Vector velocity_of(std::size_t n) const { return {velocity(n, 0), velocity(n, 1), velocity(n, 2)}; }
  Vector times_mass(std::size_t n, Vector v) const {
    for (double& c : v) c *= mass(n);
    return v;
  }
  Vector sum_over_nodes(auto&& term) const {
    std::array<std::vector<double>, 3> terms;
    for (std::size_t n = 0; n < n_nodes(); ++n) {
      const Vector value = term(n);
      for (std::size_t i = 0; i < 3; ++i) terms[i].push_back(value[i]);
    }
    return {parallel::exact_sum(self(), terms[0]), parallel::exact_sum(self(), terms[1]),
            parallel::exact_sum(self(), terms[2])};
  }
};

TEST(FreeFlight, KeepsMomentumAndAngularMomentum) {
  Block block({});
  for (std::size_t n = 0; n < block.subdomain().nodes.size(); ++n) {
    // Translates, rotates slowly, and vibrates.
    const auto& p = block.subdomain().nodes[n];
    const Vector turning = cross({1, 2, -1}, p);
    for (std::size_t i = 0; i < 3; ++i)
      block.state().velocity.local()[3 * n + i] =
          2.0 + static_cast<double>(i) + turning[i] + 0.5 * std::sin(900 * p[i]);
  }
  const Vector momentum = block.momentum(), angular = block.angular_momentum();
  block.move(4000);
  const Vector later = block.momentum(), angular_later = block.angular_momentum();
  for (std::size_t i = 0; i < 3; ++i) {
    std::printf("axis %zu: momentum changed by %.1e of %.3e N s, angular momentum by %.1e of %.3e N m s\n", i,
                later[i] - momentum[i], momentum[i], angular_later[i] - angular[i], angular[i]);
    EXPECT_NEAR(later[i], momentum[i], 1e-9 * std::abs(momentum[i]));
    EXPECT_NEAR(angular_later[i], angular[i], 1e-9 * std::sqrt(dot(angular, angular)));
  }
}

TEST(Traction, WithAHistoryGivesItsImpulse) {
  auto pulse = test::boundary(Face::z_max, BoundaryKind::traction, {}, {0, 1e5, 2e5});
  pulse.history = {{0, 0}, {1e-6, 1}, {3e-6, 1}, {4e-6, 0}};
  Block block({pulse});
  const auto n_steps = 2 * static_cast<std::int64_t>(std::ceil(3e-6 / block.step()));
  block.move(n_steps);
  const double area = size[0] * size[1];
  const Vector expected{0, 1e5 * area * 3e-6, 2e5 * area * 3e-6};
  const Vector found = block.momentum();
  std::printf("momentum %.6e, %.6e N s; impulse of the pulse %.6e, %.6e N s\n", found[1], found[2],
              expected[1], expected[2]);
  // The splitting's weights integrate the linear pieces exactly, up to their kinks.
  for (std::size_t i = 1; i < 3; ++i) EXPECT_NEAR(found[i], expected[i], 1e-3 * expected[i]);
  EXPECT_NEAR(found[0], 0, 1e-9 * expected[1]);
}

TEST(Velocity, OnAPartOfAFaceMovesThatPartOnly) {
  auto pushed = test::boundary(Face::z_max, BoundaryKind::velocity, {false, false, true}, {0, 0, 0.5});
  pushed.region[1] = {0, 0.0021};
  Block block({test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}), pushed});
  const std::int64_t n_steps = 400;
  block.move(n_steps);
  const double time = static_cast<double>(n_steps) * block.step();
  std::size_t n_pushed = 0, n_free = 0;
  for (std::size_t n = 0; n < block.subdomain().nodes.size(); ++n) {
    const auto& p = block.subdomain().nodes[n];
    const double u = block.state().displacement.local()[3 * n + 2];
    if (p[2] == 0) {
      EXPECT_EQ(u, 0);
    }
    if (p[2] != size[2]) continue;
    if (p[1] <= 0.0021) {
      ++n_pushed;
      EXPECT_NEAR(u, 0.5 * time, 1e-9 * time);
    } else {
      ++n_free;
      EXPECT_GT(std::abs(u - 0.5 * time), 1e-4 * time);
    }
  }
  std::printf("%zu nodes of the face move by %.4g mm as prescribed, %zu freely\n", n_pushed, 500 * time,
              n_free);
  EXPECT_GT(n_pushed, 4U);
  EXPECT_GT(n_free, 4U);
}

TEST(RigidMotions, ThatTheConditionsLeaveFreeAreNamed) {
  const auto mesh = test::make_box({.size = size, .cells = {3, 4, 8}});
  const auto subdomain = test::whole(mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto free_with = [&](std::vector<input::Boundary> boundaries) {
    return mechanics::free_rigid_motions(
        self, subdomain, mechanics::make_boundary_loads(self, epoxy_with(std::move(boundaries)), subdomain));
  };
  using Names = std::vector<std::string>;
  auto line = test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true});
  EXPECT_EQ(free_with({line}), Names());
  line.region[1] = {0, 1e-5};
  EXPECT_EQ(free_with({line}), Names{"turn about x"});
  auto point = line;
  point.region[0] = {0, 1e-5};
  EXPECT_EQ(free_with({point}), (Names{"turn about x", "turn about y", "turn about z"}));
  const auto slide = [](Face face, std::size_t axis) {
    std::array<bool, 3> components{};
    components[axis] = true;
    return test::boundary(face, BoundaryKind::fix, components);
  };
  EXPECT_EQ(free_with({slide(Face::z_min, 2)}), Names{"turn about z"});
  EXPECT_EQ(free_with({slide(Face::x_min, 0), slide(Face::y_min, 1), slide(Face::z_min, 2)}), Names());
  point.components = {false, true, false};
  line.components = {true, false, false};
  EXPECT_EQ(free_with({slide(Face::z_min, 2), point, line}), Names{"turn about z"});
}

TEST(Equilibrium, OfABodyThatCanTurnIsRefused) {
  auto hinge = test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true});
  hinge.region[1] = {0, 1e-5};
  auto parameters =
      epoxy_with({hinge, test::boundary(Face::z_max, BoundaryKind::force, {}, {0, 0, 10}, {0, 0, 1})});
  parameters.fracture = {.strength = 35e6, .exponent = 2, .impulse = 1e4};
  parameters.time.duration = 2e-5;
  const auto mesh = test::make_box({.size = size, .cells = {3, 4, 8}});
  const parallel::Communicator self(MPI_COMM_SELF);
  try {
    run_sample(self, parameters, parameters.output, test::whole(mesh));
    FAIL();
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("rigid-body motion is not constrained (turn about x)"),
              std::string::npos)
        << error.what();
  }
}

TEST(Motions, ThatMeetOnAnEdgeShareNoComponent) {
  auto pushed = test::boundary(Face::y_max, BoundaryKind::displacement, {false, false, true}, {0, 0, 1e-6});
  const auto parameters = epoxy_with(
      {pushed, test::boundary(Face::z_max, BoundaryKind::displacement, {false, false, true}, {0, 0, 2e-6}),
       test::boundary(Face::z_min, BoundaryKind::fix, {false, true, true})});
  const auto mesh = test::make_box({.size = size, .cells = {3, 4, 8}});
  const auto subdomain = test::whole(mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
  ASSERT_EQ(loads.motions.size(), 4U);
  std::map<std::pair<std::int32_t, int>, double> prescribed;
  for (const auto& motion : loads.motions)
    for (const auto node : motion.nodes)
      EXPECT_TRUE(prescribed.emplace(std::pair{node, motion.component}, motion.displacement(0)).second)
          << "node " << node << " has two motions";
  for (std::size_t n = 0; n < subdomain.nodes.size(); ++n) {
    const auto& p = subdomain.nodes[n];
    const auto found = prescribed.find({static_cast<std::int32_t>(n), 2});
    const double expected = p[2] == 0 ? 0 : p[1] == size[1] ? 1e-6 : p[2] == size[2] ? 2e-6 : not_a_number;
    ASSERT_EQ(found == prescribed.end(), std::isnan(expected));
    if (!std::isnan(expected)) {
      EXPECT_EQ(found->second, expected);
    }
  }
}

/// A bar held at the bottom that starts from rest and does not break: the error of its energy balance.
double energy_error_of(const char* what, std::vector<input::Boundary> boundaries, input::Engine engine,
                       input::Integrator integrator) {
  boundaries.insert(boundaries.begin(), test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}));
  auto parameters = epoxy_with(std::move(boundaries));
  parameters.fracture = {.strength = 1e12, .exponent = 2, .impulse = 1};
  parameters.time.start = input::Start::rest;
  parameters.time.duration = 2e-5;
  parameters.time.step = 5e-8;
  parameters.time.integrator = integrator;
  parameters.time.engine = engine;
  parameters.time.precision = input::Precision::double_;
  const auto mesh = test::make_box({.size = size, .cells = {3, 4, 8}, .disturbance = 0.2});
  const parallel::Communicator self(MPI_COMM_SELF);
  const double error = run_sample(self, parameters, parameters.output, test::whole(mesh)).energy_error;
  std::printf("%s, %s, %s: energy error %.1e\n", what,
              engine == input::Engine::petsc ? "petsc" : "fixed-point",
              integrator == input::Integrator::verlet ? "verlet" : "bilateral4", error);
  return error;
}

TEST(Traction, OnTheEdgeOfADrivenFaceClosesTheEnergyAccount) {
  for (const auto engine : {input::Engine::fixed_point, input::Engine::petsc})
    EXPECT_LT(energy_error_of(
                  "traction",
                  {test::boundary(Face::z_max, BoundaryKind::velocity, {false, false, true}, {0, 0, 0.5}),
                   test::boundary(Face::y_max, BoundaryKind::traction, {}, {0, 0, 5e6}, {0, 0, 1e11})},
                  engine, input::Integrator::bilateral4),
              1e-5);
}

TEST(Kinks, InsideATimeStepCloseTheEnergyAccount) {
  for (const auto engine : {input::Engine::fixed_point, input::Engine::petsc}) {
    for (const auto integrator : {input::Integrator::verlet, input::Integrator::bilateral4}) {
      auto loaded = test::boundary(Face::z_max, BoundaryKind::force, {}, {0, 0, 10});
      // Up over half the time, then down to a half within a fifth of a step.
      loaded.history = {{0, 0}, {1.003e-5, 1}, {1.004e-5, 0.5}};
      EXPECT_LT(energy_error_of("force", {loaded}, engine, integrator), 1e-2);
      loaded = test::boundary(Face::z_max, BoundaryKind::displacement, {false, false, true}, {0, 0, 1e-5});
      loaded.history = {{0, 0}, {1.003e-5, 1}, {1.004e-5, 0.99}};
      EXPECT_LT(energy_error_of("displacement", {loaded}, engine, integrator), 1e-2);
      loaded = test::boundary(Face::z_max, BoundaryKind::velocity, {false, false, true}, {0, 0, 0.5});
      loaded.history = {{0, 0}, {1.003e-5, 1}, {1.004e-5, 0.5}};
      EXPECT_LT(energy_error_of("velocity", {loaded}, engine, integrator), 1e-2);
    }
  }
}

TEST(Displacement, ThatIsThereFromTheStartIsWork) {
  auto loaded = test::boundary(Face::z_max, BoundaryKind::displacement, {false, false, true}, {0, 0, 1e-6});
  EXPECT_LT(
      energy_error_of("displacement", {loaded}, input::Engine::fixed_point, input::Integrator::bilateral4),
      1e-3);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
