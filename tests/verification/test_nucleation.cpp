// SPDX-License-Identifier: GPL-3.0-or-later
// Where cracks start with a strength and a toughness: smooth bodies break near the strength, slots at the
// load that the toughness gives; and how fast they spread then.
#include "common/real.h"
#include "common/vector.h"
#include "dynamics/sample_run.h"
#include "geometry/point.h"
#include "mechanics/elasticity.h"
#include "support/box_mesh.h"
#include "support/job.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

/// A bar of epoxy in tension. From the toughness alone its coarse tetrahedra would get 20 MPa.
input::Parameters bar() {
  input::Parameters parameters;
  parameters.materials[0] = test::epoxy();
  parameters.fracture = {.strength = 70e6, .impulse = 1e4, .release_time = 0, .toughness = 93};
  parameters.specimen.size = {4e-3, 4e-3, 12e-3};
  parameters.mesh.spacing = parameters.mesh.notch_spacing = 1.2e-3;
  parameters.time.duration = 2e-5;
  parameters.time.integrator = input::Integrator::verlet;
  parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {false, false, true}));
  parameters.boundaries.push_back(test::boundary(Face::x_min, BoundaryKind::fix, {true, false, false}));
  parameters.boundaries.push_back(test::boundary(Face::y_min, BoundaryKind::fix, {false, true, false}));
  parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10}));
  return parameters;
}

double first_break_load(const input::Parameters& parameters) {
  const parallel::Communicator self(MPI_COMM_SELF);
  return run_sample(self, parameters, parameters.output, test::whole(test::realization(parameters)))
      .first_break_load;
}

TEST(Nucleation, SmoothBarBreaksAtItsStrength) {
  auto parameters = bar();
  const double area = parameters.specimen.size[0] * parameters.specimen.size[1];
  const double both = first_break_load(parameters);
  parameters.fracture.strength = 0;
  const double toughness_only = first_break_load(parameters);
  std::printf("first break over strength times area: %.4f (reference 1), with the toughness alone %.3f\n",
              both / (70e6 * area), toughness_only / (70e6 * area));
  EXPECT_NEAR(both, 70e6 * area, 1e-3 * 70e6 * area);
  EXPECT_LT(toughness_only, 0.5 * both);
}

TEST(Nucleation, SlotBreaksAtTheLoadOfTheToughness) {
  auto parameters = bar();
  plane::Notch notch;
  notch.at = 6e-3;
  notch.depth = 1.5e-3;
  notch.height = 0.6e-3;
  parameters.specimen.notches.push_back(notch);
  parameters.mesh.notch_spacing = 0.6e-3;
  parameters.mesh.growth = 0.2;
  const double both = first_break_load(parameters);
  parameters.specimen.notches[0].height = 1.2e-3;  // two cells: no crack
  const double smooth = first_break_load(parameters);
  parameters.fracture.nucleation = input::Nucleation::own_stress;
  const double by_own_stress = first_break_load(parameters);
  parameters.fracture.strength = 0;
  const double high_toughness_only = first_break_load(parameters);
  parameters.specimen.notches[0].height = 0.6e-3;
  const double toughness_only = first_break_load(parameters);
  std::printf(
      "first break at a slot of one cell: %.3f N with strength and toughness, %.3f N with the toughness "
      "alone; of two cells: %.3f N, %.3f N\n",
      both, toughness_only, smooth, high_toughness_only);
  EXPECT_EQ(both, toughness_only);
  EXPECT_EQ(by_own_stress, high_toughness_only) << "every square end was a crack";
  EXPECT_GT(smooth, 1.5 * high_toughness_only);
}

/// Fine tetrahedra need more than the strength to take the toughness, at cracks only.
TEST(Nucleation, TheStrengthHoldsAwayFromCracksOnAFineMeshToo) {
  auto parameters = bar();
  const double area = parameters.specimen.size[0] * parameters.specimen.size[1];
  parameters.fracture.strength = 6e6;
  EXPECT_NEAR(first_break_load(parameters), 6e6 * area, 1e-3 * 6e6 * area);
  parameters.fracture.nucleation = input::Nucleation::own_stress;
  const double by_own_stress = first_break_load(parameters);
  parameters.fracture.strength = 0;
  EXPECT_EQ(by_own_stress, first_break_load(parameters)) << "the higher one held everywhere";
}

/// Mean load at the first break of some samples [N].
double mean_first_break_load(const input::Parameters& parameters) {
  constexpr std::uint64_t n_samples = 4;
  const parallel::Communicator self(MPI_COMM_SELF);
  double sum = 0;
  for (std::uint64_t sample = 0; sample < n_samples; ++sample) {
    SampleControl control;
    control.sample = sample;
    const auto subdomain = test::whole(test::realization(parameters, sample));
    sum += run_sample(self, parameters, parameters.output, subdomain, control).first_break_load;
  }
  return sum / n_samples;
}

/// Alumina, whose coarse tetrahedra would get 176 MPa from the toughness alone.
void make_alumina(input::Parameters& parameters) {
  parameters.materials[0] = {.youngs_modulus = 380e9, .poisson_ratio = 0.2, .density = 3900};
  parameters.fracture = {.strength = 400e6, .impulse = 1e4, .release_time = 0, .toughness = 42};
  parameters.mesh.spacing = 0.8e-3;
  parameters.time.duration = 1e-8;
}

input::Parameters bent_bar() {
  auto parameters = test::job("gallery/bend-bar.toml");
  make_alumina(parameters);
  parameters.specimen.size[0] = 2e-3;
  parameters.mesh.regions[0].spacing = 0.6e-3;
  return parameters;
}

// The own stress of tetrahedra scatters where the strain varies, the more the higher Poisson's ratio: the
// most loaded of many is 13 and 27 % beyond the exact one. Means around nodes are within some 7 %.
TEST(Nucleation, BentBarBreaksNearTheLoadOfTheExactStress) {
  for (const double nu : {0.2, 0.38}) {
    auto parameters = bent_bar();
    parameters.materials[0].poisson_ratio = nu;
    const auto stress = [&] {
      return 3 * mean_first_break_load(parameters) * 10e-3 / (2e-3 * 3e-3 * 3e-3) / 400e6;
    };
    const double by_means = stress();
    parameters.fracture.nucleation = input::Nucleation::own_stress;
    const double by_own_stress = stress();
    std::printf(
        "bent bar, nu = %.2f: %.3f of the strength at the first break, by beam theory; %.3f by own stress\n",
        nu, by_means, by_own_stress);
    EXPECT_NEAR(by_means, 1.05, 0.05);
    EXPECT_LT(by_own_stress, 0.95);
  }
}

TEST(Nucleation, HoleBreaksNearTheLoadOfTheExactStress) {
  auto parameters = test::job("gallery/plate-with-hole.toml");
  make_alumina(parameters);
  parameters.mesh.base = input::Base::shared;
  parameters.specimen.size[0] = 1e-3;
  parameters.mesh.regions[0].spacing = 0.6e-3;
  constexpr double howland = 3.37;  // 0.3 of the width
  const double stress = howland * mean_first_break_load(parameters) / (1e-3 * 20e-3);
  std::printf("hole: %.3f of the strength at the first break, by Howland\n", stress / 400e6);
  EXPECT_NEAR(stress, 1.07 * 400e6, 0.05 * 400e6);
}

// The stress at the bar's surface is twice the threshold at a crack. Tetrahedra that share a node are up
// to 1.5 spacings apart.
TEST(Nucleation, BreaksAreNotFasterThanWaves) {
  auto parameters = bent_bar();
  parameters.time.duration = 4e-7;
  const auto subdomain = test::whole(test::realization(parameters));
  const auto breaks =
      run_sample(parallel::Communicator(MPI_COMM_SELF), parameters, parameters.output, subdomain).breaks;
  ASSERT_GT(breaks.size(), 20u);
  const auto place = [&](const fracture::Break& one) {
    return geometry::centroid(subdomain.nodes, subdomain.tetrahedra[index(one.tetrahedron)]);
  };
  const double wave = mechanics::dilatational_speed(parameters.material());
  double fastest = 0;
  for (const fracture::Break& later : breaks) {
    double nearest = infinity;
    for (const fracture::Break& first : breaks)
      if (first.phase_time == 0) nearest = std::min(nearest, norm(place(later) - place(first)));
    if (later.phase_time > 1e-7) fastest = std::max(fastest, nearest / later.phase_time);
  }
  std::printf("breaks spread at %.2f of the speed of dilatational waves\n", fastest / wave);
  EXPECT_LT(fastest, 1.5 * wave);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
