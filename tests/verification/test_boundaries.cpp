// SPDX-License-Identifier: GPL-3.0-or-later
// The boundary list at work in dynamics: motions of a part of a face, loads with a history, free flight.
#include "crackle/dynamics/moving_body.h"
#include "crackle/dynamics/stable_step.h"
#include "crackle/parallel/exact_sum.h"
#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace crackle::dynamics {
namespace {

using input::BoundaryKind;
using input::Face;
using mechanics::Vector;

/// A small epoxy block with a boundary list.
class Block {
public:
  explicit Block(std::vector<input::Boundary> boundaries)
      : mesh_(test::make_box({.size = size, .cells = {3, 4, 8}, .disturbance = 0.2})),
        subdomain_(test::whole(mesh_)),
        body_(subdomain_, test::epoxy()),
        strength_(subdomain_.tetrahedra.size(), 35e6),
        state_{parallel::NodeField(self_, subdomain_), parallel::NodeField(self_, subdomain_)} {
    input::Parameters parameters;
    parameters.specimen.size = size;
    parameters.boundaries = std::move(boundaries);
    loads_ = mechanics::make_boundary_loads(self_, parameters, subdomain_);
    step_ = 0.5 * splitting(input::Integrator::bilateral4).stability_limit /
            largest_frequency(self_, subdomain_, body_.operators(), body_.force());
  }

  void move(std::int64_t n_steps) {
    const MotionContext context{&self_, &body_, &loads_, test::epoxy().density, strength_};
    const auto motion = make_fixed_point_motion(context, input::Precision::double_, 0,
                                                static_cast<double>(n_steps) * step_, state_);
    const auto& map = splitting(input::Integrator::bilateral4);
    for (std::int64_t i = 0; i < n_steps; ++i)
      motion->step(i % 2 == 0 ? map.even : map.odd, step_, static_cast<double>(i) * step_);
    motion->read(state_);
    EXPECT_FALSE(motion->failure());
  }

  Vector momentum() const {
    return sum_over_nodes([&](std::size_t n) { return scaled(mass(n), velocity(n)); });
  }
  /// About the origin, with the undeformed positions: that is what linear elasticity keeps exactly.
  Vector angular_momentum() const {
    return sum_over_nodes(
        [&](std::size_t n) { return scaled(mass(n), mechanics::cross(subdomain_.nodes[n], velocity(n))); });
  }

  double mass(std::size_t n) const { return body_.operators().node_mass[n]; }
  Vector velocity(std::size_t n) const {
    return {state_.velocity.owned()[3 * n], state_.velocity.owned()[3 * n + 1],
            state_.velocity.owned()[3 * n + 2]};
  }
  const geometry::Subdomain& subdomain() const { return subdomain_; }
  MotionState& state() { return state_; }
  double step() const { return step_; }

  static constexpr geometry::Point size{0.003, 0.004, 0.008};

private:
  static Vector scaled(double factor, Vector v) {
    for (double& c : v) c *= factor;
    return v;
  }
  Vector sum_over_nodes(auto&& term) const {
    std::array<std::vector<double>, 3> terms;
    for (std::size_t n = 0; n < subdomain_.nodes.size(); ++n) {
      const Vector value = term(n);
      for (std::size_t i = 0; i < 3; ++i) terms[i].push_back(value[i]);
    }
    return {parallel::exact_sum(self_, terms[0]), parallel::exact_sum(self_, terms[1]),
            parallel::exact_sum(self_, terms[2])};
  }

  parallel::Communicator self_{MPI_COMM_SELF};
  geometry::Realization mesh_;
  geometry::Subdomain subdomain_;
  fracture::BreakableBody body_;
  std::vector<double> strength_;
  mechanics::BoundaryLoads loads_;
  MotionState state_;
  double step_ = 0;
};

TEST(FreeFlight, KeepsMomentumAndAngularMomentum) {
  Block block({});
  for (std::size_t n = 0; n < block.subdomain().nodes.size(); ++n) {
    // Flies, turns slowly, and vibrates.
    const auto& p = block.subdomain().nodes[n];
    const Vector turning = mechanics::cross({1, 2, -1}, p);
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
    EXPECT_NEAR(angular_later[i], angular[i], 1e-9 * std::sqrt(mechanics::dot(angular, angular)));
  }
}

TEST(Traction, WithAHistoryGivesItsImpulse) {
  auto pulse = test::boundary(Face::z_max, BoundaryKind::traction, {}, {0, 1e5, 2e5});
  pulse.history = {{0, 0}, {1e-6, 1}, {3e-6, 1}, {4e-6, 0}};
  Block block({pulse});
  const auto n_steps = 2 * static_cast<std::int64_t>(std::ceil(3e-6 / block.step()));
  block.move(n_steps);
  const double area = Block::size[0] * Block::size[1];
  const Vector expected{0, 1e5 * area * 3e-6, 2e5 * area * 3e-6};
  const Vector found = block.momentum();
  std::printf("momentum %.6e, %.6e N s; impulse of the pulse %.6e, %.6e N s\n", found[1], found[2],
              expected[1], expected[2]);
  // The splitting's weights integrate the linear pieces up to their kinks.
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
    if (p[2] != Block::size[2]) continue;
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

}  // namespace
}  // namespace crackle::dynamics
