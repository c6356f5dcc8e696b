// SPDX-License-Identifier: GPL-3.0-or-later
// The range of toughness of a uniform strength along the crack paths.
#include "crackle/fracture/toughness.h"
#include "support/geometry_bodies.h"
#include "support/job.h"

#include <gtest/gtest.h>

namespace crackle::fracture {
namespace CRACKLE_TEST_FILE {

Range along_ligaments(const input::Parameters& parameters) {
  return toughness_along_ligaments(parameters, geometry::ExtrudedPlate(parameters.specimen),
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
  parameters.mesh.regions = {testing::region({input::unbounded, input::unbounded, {60, 80}}, 0.3)};
  const Range range = along_ligaments(parameters);
  EXPECT_DOUBLE_EQ(range.greatest, range.least);
  // A region that excludes part of the thickness does not count.
  parameters.mesh.regions = {testing::region({{{0, 2}, input::unbounded, {60, 80}}}, 0.3)};
  EXPECT_GT(along_ligaments(parameters).greatest, 1.1 * range.greatest);
}

TEST(LigamentToughness, EndsAtTheNextNotch) {
  input::Parameters parameters = test::job("paper/clock-from-zero.toml");
  parameters.specimen.notches = {testing::notch(input::Face::y_min, 70, 10, 0.6),
                                 testing::notch(input::Face::y_max, 70, 10, 0.6)};
  const Range range = along_ligaments(parameters);
  EXPECT_NEAR(range.greatest / range.least, 1 + 0.03 * 2.25 / 0.3, 0.01);
  parameters.specimen.notches.clear();
  EXPECT_FALSE(
      toughness_along_ligaments(parameters, geometry::ExtrudedPlate(parameters.specimen), 35e6).has_value());
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::fracture
