// SPDX-License-Identifier: GPL-3.0-or-later
// The failure load of a cracked strip, with a toughness and with a strength, at three spacings.
#include "dynamics/sample_run.h"
#include "fracture/toughness.h"
#include "mechanics/elasticity.h"
#include "support/box_mesh.h"
#include "support/effort.h"
#include "support/job.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

/// A strip between rigid grips, with a crack along half of its mid-plane.
input::Parameters strip() {
  input::Parameters parameters;
  parameters.materials[0] = {32e9, 0.2, 2450};
  parameters.fracture = {.impulse = 1e4, .release_time = 0};
  parameters.time.duration = 3e-5;
  parameters.time.integrator = input::Integrator::verlet;
  parameters.specimen.size = {0.001, 0.024, 0.008};
  for (const Face face : {Face::x_min, Face::x_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {true, false, false}));
  parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}));
  parameters.boundaries.push_back(
      test::boundary(Face::z_max, BoundaryKind::displacement, {true, true, true}, {}, {0, 0, 1e-6}));
  return parameters;
}

geometry::Realization strip_mesh(const input::Parameters& parameters, int cells) {
  const double spacing = parameters.specimen.size[2] / cells;
  return test::make_box({.size = parameters.specimen.size,
                         .cells = {std::max(1, cells / 8), 3 * cells, cells},
                         .disturbance = 0.2,
                         .removed = [=](const geometry::Point& p) {
                           return p[1] < 0.010 && p[2] > 0.004 && p[2] < 0.004 + spacing;
                         }});
}

double run_away_travel(const input::Parameters& parameters, int cells) {
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto mesh = strip_mesh(parameters, cells);
  const auto result = run_sample(self, parameters, parameters.output, test::whole(mesh));
  return 1e-6 * result.onset_time;
}

TEST(Toughness, MakesTheLoadAtRunAwayIndependentOfTheSpacing) {
  auto parameters = strip();
  parameters.fracture.toughness = 30;
  const double height = parameters.specimen.size[2];
  const mechanics::IsotropicElasticity elasticity(parameters.material());
  const double griffith = std::sqrt(2 * 30 * height / (elasticity.lambda + 2 * elasticity.mu));
  std::vector<double> tough, strong;
  for (const int cells : {8, 12, 16}) {
    tough.push_back(run_away_travel(parameters, cells) / griffith);
    auto with_strength = parameters;
    with_strength.fracture.toughness = 0;
    with_strength.fracture.strength = fracture::strength_of(parameters, 30, height / 12);
    strong.push_back(run_away_travel(with_strength, cells) / griffith);
    std::printf(
        "spacing %.2f mm: load at instability over Griffith's %.3f with toughness (reference 1), %.3f with "
        "strength\n",
        1e3 * height / cells, tough.back(), strong.back());
  }
  const auto spread = [](const std::vector<double>& values) {
    return std::ranges::max(values) / std::ranges::min(values);
  };
  std::printf("largest over smallest: %.3f with toughness, %.3f with strength (root of the spacings: %.3f)\n",
              spread(tough), spread(strong), std::sqrt(2.0));
  EXPECT_LT(spread(tough), 1.15);
  EXPECT_GT(spread(strong), 1.25);
  for (const double load : tough) EXPECT_NEAR(load, 1, 0.1);
}

/// The strip of jobs/verification/griffith-strip.toml on a coarser mesh, whose exact load is known for every
/// Poisson's ratio.
class CrackedStrip : public ::testing::TestWithParam<double> {};

TEST_P(CrackedStrip, BecomesUnstableAtTheLoadThatItsToughnessPredicts) {
  if (GetParam() == 0.2 && !test::is_full()) GTEST_SKIP() << "lies between the others";
  auto parameters = test::job("verification/griffith-strip.toml");
  const double nu = parameters.materials[0].poisson_ratio = GetParam();
  parameters.mesh.regions.front().spacing = 1e-3;
  // For the strength alone: slow release lets cracks stop at strong places (verify toughness).
  parameters.fracture.release_time = 0;
  const double stiffness = parameters.materials[0].youngs_modulus / (1 - nu * nu);
  const double griffith =
      std::sqrt(2 * parameters.fracture.toughness * parameters.specimen.size[2] / stiffness);
  const parallel::Communicator self(MPI_COMM_SELF);
  const int n_bodies =
      nu > 0.4 ? test::repetitions(4, 8) : test::repetitions(2, 4);  // at 0.45 samples scatter by 9 %
  double mean = 0;
  for (int body = 1; body <= n_bodies; ++body) {
    parameters.seed = static_cast<std::uint64_t>(body);
    const auto mesh = test::realization(parameters);
    const auto result = run_sample(self, parameters, parameters.output, test::whole(mesh));
    mean += 1e-6 * result.onset_time / griffith / n_bodies;
  }
  std::printf("Poisson's ratio %.2f: load at instability over Griffith's %.3f (reference 1)\n", nu, mean);
  EXPECT_NEAR(mean, 1, 0.1);
}

INSTANTIATE_TEST_SUITE_P(PoissonsRatio, CrackedStrip, ::testing::Values(0.0, 0.2, 0.45));

TEST(Toughness, SpacingIsThatOfTheMesh) {
  // A cube of six tetrahedra, each V = h^3 / 6.
  const auto mesh = test::make_box({.size = {0.006, 0.006, 0.006}, .cells = {6, 6, 6}});
  const auto subdomain = test::whole(mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto operators = mechanics::make_operators(subdomain, 1);
  for (const double spacing : fracture::local_spacings(self, subdomain, operators))
    EXPECT_NEAR(spacing, 1e-3 * std::cbrt(std::sqrt(2.0)), 1e-12);
}

TEST(Rayleigh, SpeedOfTheGlassPlateIsThatOfTheLiterature) {
  EXPECT_NEAR(mechanics::rayleigh_speed({32e9, 0.2, 2450}), 2125, 5);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
