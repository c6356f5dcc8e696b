// SPDX-License-Identifier: GPL-3.0-or-later
// Static equilibrium and onset against exact solutions of uniformly stressed bodies.
#include "common/index.h"
#include "dynamics/quasi_static.h"

#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

constexpr double length = 0.02, width = 0.006, thickness = 0.004;

/// A bar whose loads are added by the test, with all parts of a quasi-static phase.
struct Bar {
  input::Parameters parameters = test::brittle({thickness, width, length});
  parallel::Communicator self{MPI_COMM_SELF};
  geometry::Realization mesh;
  geometry::Subdomain subdomain;

  explicit Bar(const test::BoxMesh& box = {
                   .size = {thickness, width, length}, .cells = {3, 4, 8}, .disturbance = 0.2}) {
    mesh = test::make_box(box);
    subdomain = test::whole(mesh);
  }

  /// Six components at three corners: holds the body without stress under balanced loads.
  void hold_at_corners() {
    const auto hold = [&](double y, double z, std::array<bool, 3> components) {
      auto corner = test::boundary(Face::x_min, BoundaryKind::fix, components);
      corner.region[1] = {y, y};
      corner.region[2] = {z, z};
      parameters.boundaries.push_back(corner);
    };
    hold(0, 0, {true, true, true});
    hold(0, length, {true, true, false});
    hold(width, 0, {true, false, false});
  }
};

TEST(Static, BarInTensionHasTheExactDisplacement) {
  Bar bar;
  for (const auto& [face, axis] : {std::pair{Face::x_min, 0}, {Face::y_min, 1}, {Face::z_min, 2}}) {
    std::array<bool, 3> components{};
    components[index(axis)] = true;
    bar.parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, components));
  }
  const double stress = 10e6;
  bar.parameters.boundaries.push_back(
      test::boundary(Face::z_max, BoundaryKind::force, {}, {0, 0, stress * width * thickness}));
  fracture::BreakableBody body(bar.subdomain, bar.parameters.material());
  const auto loads = mechanics::make_boundary_loads(bar.self, bar.parameters, bar.subdomain);
  auto law = test::tuler_butcher(bar.parameters.fracture, bar.subdomain);
  const QuasiStaticLoading loading(bar.self, body, loads, law, 1e-5);

  const double strain = stress / bar.parameters.materials[0].youngs_modulus;
  double worst = 0;
  const auto u = loading.displacement().local();
  for (std::size_t n = 0; n < bar.subdomain.nodes.size(); ++n) {
    const auto& p = bar.subdomain.nodes[n];
    const double exact[3] = {-0.38 * strain * p[0], -0.38 * strain * p[1], strain * p[2]};
    for (std::size_t i = 0; i < 3; ++i)
      worst = std::max(worst, std::abs(u[3 * n + i] - exact[i]) / (strain * length));
  }
  std::printf("bar in tension: largest displacement error %.2e of the elongation\n", worst);
  EXPECT_LT(worst, 1e-7);

  const double energy = strain_energy(bar.self, body, loading.displacement().local());
  EXPECT_NEAR(energy, 0.5 * stress * strain * length * width * thickness, 1e-8 * energy);
}

/// A bar held at the nodes selected by `is_held`, without its history.
class HeldBar {
public:
  template <class IsHeld>
  HeldBar(const Bar& bar, const IsHeld& is_held)
      : bar_(&bar), body_(bar.subdomain, bar.parameters.material()) {
    for (const auto& node : bar.subdomain.nodes) held_.insert(held_.end(), 3, is_held(node) ? 1 : 0);
    solver_.emplace(bar.self, bar.subdomain, body_.operators(), body_.elasticity(), body_.edges(),
                    body_.residual_stiffness(), held_);
  }

  const mechanics::HeldComponents& held() const { return held_; }
  parallel::NodeField displacement() const { return {bar_->self, bar_->subdomain.layout}; }
  /// Without forces. @return number of iterations
  int solve(parallel::NodeField& displacement, const mechanics::Accuracy& accuracy = {}) {
    return solver_->solve(std::vector<double>(displacement.owned().size(), 0.0), displacement, accuracy);
  }
  double energy(std::span<const double> displacement) const {
    return strain_energy(bar_->self, body_, displacement);
  }

private:
  const Bar* bar_;
  fracture::BreakableBody body_;
  mechanics::HeldComponents held_;
  std::optional<mechanics::StaticSolver> solver_;
};

TEST(Static, WithoutLoadsTheGuessIsForgotten) {
  const Bar bar;
  HeldBar held(bar, [](const geometry::Point& node) { return node[2] == 0; });
  auto displacement = held.displacement();
  for (std::size_t i = 0; i < held.held().size(); ++i)
    displacement.local()[i] = held.held()[i] != 0 ? 0 : 1e-6;
  held.solve(displacement);
  EXPECT_EQ(std::ranges::count(displacement.local(), 0.0), std::ssize(displacement.local()));
}

/// As long as nothing else has moved, the mesh layer next to a moving face has all the strain: energy and
/// residual are far above those of the equilibrium.
TEST(Static, AccuracyUnderPrescribedMotionsIsThatOfTheDisplacement) {
  const Bar bar({.size = {0.001, 0.001, 0.1}, .cells = {2, 2, 200}, .disturbance = 0.2});
  HeldBar held(bar, [](const geometry::Point& node) { return node[2] == 0 || node[2] == 0.1; });
  const auto error = [&](const mechanics::Accuracy& accuracy) {
    auto exact = held.displacement();
    for (std::size_t n = 0; n < bar.subdomain.nodes.size(); ++n)
      if (bar.subdomain.nodes[n][2] == 0.1) exact.local()[3 * n + 2] = 1e-5;
    auto rough = held.displacement();
    rough.assign(exact);
    held.solve(exact);
    const int n_iterations = held.solve(rough, accuracy);
    std::vector<double> difference(exact.local().size());
    std::ranges::transform(exact.local(), rough.local(), difference.begin(), std::minus());
    const double share = std::sqrt(held.energy(difference) / held.energy(exact.local()));
    std::printf("accuracy %.0e of the loads, %.0e of the displacement: off by %.1e after %d iterations\n",
                accuracy.of_loads, accuracy.of_displacement, share, n_iterations);
    return share;
  };
  EXPECT_GT(error({.of_loads = 1e-3}), 5e-2) << "or the test says nothing";
  EXPECT_LT(error({.of_loads = 1e-3, .of_displacement = 1e-3}), 2e-2);
}

/// A long thin beam has large displacements under small loads, so the product's rounding exceeds the
/// tolerance.
TEST(Static, RoundingIsNoLackOfEquilibrium) {
  Bar beam({.size = {0.001, 0.001, 0.1}, .cells = {1, 1, 100}, .disturbance = 0.2});
  beam.parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}));
  beam.parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::force, {}, {0, 1e-4, 0}));
  fracture::BreakableBody body(beam.subdomain, beam.parameters.material());
  const auto loads = mechanics::make_boundary_loads(beam.self, beam.parameters, beam.subdomain);
  auto law = test::tuler_butcher(beam.parameters.fracture, beam.subdomain);
  const QuasiStaticLoading loading(beam.self, body, loads, law, 1e-5);
  std::printf("cantilever 100 times as long as thick: residual %.1e of the load\n", loading.residual());
  EXPECT_GT(loading.residual(), 3e-10) << "or the test says nothing";
  EXPECT_LT(loading.residual(), 1e-7);
}

struct OnsetCase {
  double lateral;  ///< constant stress across the bar [Pa]
  double shear;    ///< constant shear stress [Pa]
};

class Onset : public ::testing::TestWithParam<OnsetCase> {};

TEST_P(Onset, IsExactUnderLateralAndShearStress) {
  const auto [lateral, shear] = GetParam();
  const double rate = 1e6;
  Bar bar;
  bar.hold_at_corners();
  const auto traction = [&](Face face, Vector value, Vector change = {}) {
    bar.parameters.boundaries.push_back(test::boundary(face, BoundaryKind::traction, {}, value, change));
  };
  traction(Face::z_max, {0, shear, 0}, {0, 0, rate});
  traction(Face::z_min, {0, -shear, 0}, {0, 0, -rate});
  traction(Face::y_max, {0, lateral, shear});
  traction(Face::y_min, {0, -lateral, -shear});
  fracture::BreakableBody body(bar.subdomain, bar.parameters.material());
  const auto loads = mechanics::make_boundary_loads(bar.self, bar.parameters, bar.subdomain);
  auto law = test::tuler_butcher(bar.parameters.fracture, bar.subdomain);
  QuasiStaticLoading loading(bar.self, body, loads, law, 1e-3);
  EnergyAccount account(bar.self, body);
  EXPECT_EQ(loading.advance(account), QuasiStaticEnd::unstable);

  // sigma_1 of [[p, tau], [tau, s]] equals sigma_0 at s = sigma_0 - tau^2 / (sigma_0 - p).
  const double exact = (35e6 - shear * shear / (35e6 - lateral)) / rate;
  std::printf("lateral %5.1f MPa, shear %5.1f MPa: onset %.9f s, exact %.9f s\n", lateral * 1e-6,
              shear * 1e-6, loading.time(), exact);
  EXPECT_NEAR(loading.time(), exact, 5e-7 * exact);
  EXPECT_GE(loading.n_breaks(), 1);
}

INSTANTIATE_TEST_SUITE_P(Family, Onset,
                         ::testing::Values(OnsetCase{0, 0}, OnsetCase{10e6, 0}, OnsetCase{-20e6, 0},
                                           OnsetCase{0, 10e6}, OnsetCase{10e6, 12e6}, OnsetCase{-15e6, 20e6},
                                           OnsetCase{20e6, 5e6}, OnsetCase{30e6, 2e6}));

/// Loads the bar by a force of 1 N times this history at both ends.
QuasiStaticEnd end_of(Bar& bar, const std::vector<std::pair<double, double>>& history, double& time) {
  bar.hold_at_corners();
  for (const double sign : {1.0, -1.0}) {
    auto load = test::boundary(sign > 0 ? Face::z_max : Face::z_min, BoundaryKind::force, {}, {0, 0, sign});
    load.history = history;
    bar.parameters.boundaries.push_back(load);
  }
  fracture::BreakableBody body(bar.subdomain, bar.parameters.material());
  const auto loads = mechanics::make_boundary_loads(bar.self, bar.parameters, bar.subdomain);
  auto law = test::tuler_butcher(bar.parameters.fracture, bar.subdomain);
  QuasiStaticLoading loading(bar.self, body, loads, law, 1e-3);
  EnergyAccount account(bar.self, body);
  const QuasiStaticEnd end = loading.advance(account);
  time = loading.time();
  EXPECT_EQ(body.breaks().empty(), end == QuasiStaticEnd::no_load);
  return end;
}

TEST(Static, LoadHistoryIsFollowedFromKinkToKink) {
  Bar bar;
  const double unit = 10e6 * width * thickness;
  double time = 0;
  // 20 MPa after 1 s, down to 10 MPa at 2 s, 50 MPa at 4 s: 35 MPa are reached at 3.25 s.
  EXPECT_EQ(end_of(bar, {{0, 0}, {1, 2 * unit}, {2, unit}, {4, 5 * unit}}, time), QuasiStaticEnd::unstable);
  std::printf("onset %.9f s, exact 3.25 s\n", time);
  EXPECT_NEAR(time, 3.25, 1e-6);
}

TEST(Static, LoadThatStaysTooSmallBreaksNothing) {
  Bar bar;
  const double peak = 34.99e6 * width * thickness;
  double time = 0;
  EXPECT_EQ(end_of(bar, {{0, 0}, {1, peak}, {2, peak / 2}}, time), QuasiStaticEnd::no_load);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
