// SPDX-License-Identifier: GPL-3.0-or-later
// The relation between strength and toughness, by Poisson's ratio, and along the crack paths.
#include "fracture/toughness.h"

#include "dynamics/resolution.h"
#include "input/poisson_limits.h"
#include "support/geometry_bodies.h"
#include "support/job.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>

namespace crackle::fracture {
namespace CRACKLE_TEST_FILE {

constexpr double least = input::least_measured_poisson_ratio;
constexpr double greatest = input::greatest_measured_poisson_ratio;

using input::Release;

TEST(ToughnessFactor, IsTheOneThatWasMeasured) {
  // For single tetrahedra, from jobs/verification/verify toughness: measured over predicted load, squared.
  for (const auto& [nu, measured] :
       {std::pair{0.0, 0.92}, std::pair{0.2, 0.87}, std::pair{0.38, 0.67}, std::pair{0.45, 0.45}})
    EXPECT_NEAR(toughness_factor(Release::element, nu), measured, 0.04 * measured) << nu;
}

TEST(ToughnessFactor, FallsSmoothlyWithPoissonsRatio) {
  constexpr double step = 0.01;
  for (const auto release : {Release::element, Release::facet}) {
    for (double nu = least; nu + 2 * step <= greatest; nu += step) {
      const std::array values{toughness_factor(release, nu), toughness_factor(release, nu + step),
                              toughness_factor(release, nu + 2 * step)};
      EXPECT_LT(values[1], 1.001 * values[0]) << nu;
      EXPECT_LT(values[2] - 2 * values[1] + values[0], 0) << nu;  // without kinks
      EXPECT_GT(values[2] - 2 * values[1] + values[0], -0.02) << nu;
    }
  }
}

TEST(ToughnessFactor, LinksStrengthAndToughness) {
  input::Parameters epoxy;
  epoxy.materials[0] = {3.3e9, 0.38, 1180};
  const double strength = strength_of(epoxy, 60, 0.3e-3);
  EXPECT_NEAR(strength, 31.8e6, 0.05e6);  // as jobs/paper/README.md says
  EXPECT_NEAR(toughness_of(epoxy, strength, 0.3e-3), 60, 1e-10);
  EXPECT_NEAR(toughness_of(epoxy, 2 * strength, 0.6e-3), 8 * 60, 1e-9);
  // Release by facets dissipates somewhat more, so the same toughness requires less strength.
  epoxy.fracture.release = Release::facet;
  EXPECT_LT(strength_of(epoxy, 60, 0.3e-3), strength);
  EXPECT_GT(strength_of(epoxy, 60, 0.3e-3), 0.96 * strength);
}

TEST(ToughnessFactor, OfAnAverageIsThatOfALengthOfItsOwn) {
  for (const double nu : {least, 0.2, greatest}) {
    EXPECT_GT(spacings_per_length(input::Release::element, nu), 2);
    EXPECT_LE(spacings_per_length(input::Release::element, least),
              spacings_per_length(input::Release::element, nu));
  }
}

Range along_ligaments(const input::Parameters& parameters) {
  return dynamics::toughness_along_ligaments(parameters, *geometry::make_body(parameters.specimen),
                                             parameters.fracture.strength)
      .value();
}

TEST(LigamentToughness, GrowsWithTheSpacingOfAGradedMesh) {
  const auto parameters = test::job("paper/clock-from-zero.toml");
  const Range range = along_ligaments(parameters);
  EXPECT_DOUBLE_EQ(range.least,
                   toughness_of(parameters, parameters.fracture.strength, parameters.mesh.notch_spacing));
  // The point farthest from both tips: midway between them, 5 mm apart along the length.
  EXPECT_NEAR(range.greatest / range.least, 1 + 0.03 * 7.6 / 0.3, 0.05);
}

TEST(LigamentToughness, IsEvenInACorridor) {
  auto parameters = test::job("paper/clock-from-zero.toml");
  parameters.mesh.regions = {testing::region({plane::unbounded, plane::unbounded, {60, 80}}, 0.3)};
  const Range range = along_ligaments(parameters);
  EXPECT_DOUBLE_EQ(range.greatest, range.least);
  // A region that excludes part of the thickness does not count.
  parameters.mesh.regions = {testing::region({{{0, 2}, plane::unbounded, {60, 80}}}, 0.3)};
  EXPECT_GT(along_ligaments(parameters).greatest, 1.1 * range.greatest);
}

TEST(LigamentToughness, EndsAtTheNextNotch) {
  input::Parameters parameters = test::job("paper/clock-from-zero.toml");
  parameters.specimen.notches = {testing::notch(plane::Face::y_min, 70, 10, 0.6),
                                 testing::notch(plane::Face::y_max, 70, 10, 0.6)};
  const Range range = along_ligaments(parameters);
  EXPECT_NEAR(range.greatest / range.least, 1 + 0.03 * 2.25 / 0.3, 0.01);
  parameters.specimen.notches.clear();
  EXPECT_FALSE(
      dynamics::toughness_along_ligaments(parameters, *geometry::make_body(parameters.specimen), 35e6)
          .has_value());
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::fracture
