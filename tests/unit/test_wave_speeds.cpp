// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/sample_run.h"
#include "crackle/mechanics/elasticity.h"

#include <gtest/gtest.h>

#include <cmath>

namespace crackle::mechanics {
namespace CRACKLE_TEST_FILE {

TEST(WaveSpeeds, AreThoseOfTheTextbook) {
  // Steel, common table values: 5.9 and 3.2 km/s, Rayleigh wave at 0.926 of the latter.
  const input::Material steel{210e9, 0.29, 7850};
  EXPECT_NEAR(dilatational_speed(steel), 5920, 10);
  EXPECT_NEAR(shear_speed(steel), 3220, 10);
  EXPECT_NEAR(rayleigh_speed(steel) / shear_speed(steel), 0.926, 0.001);
  for (const double nu : {0.0, 0.25, 0.38, 0.49}) {
    const input::Material material{3.3e9, nu, 1180};
    EXPECT_NEAR(std::pow(dilatational_speed(material) / shear_speed(material), 2),
                2 * (1 - nu) / (1 - 2 * nu), 1e-9);
  }
}

TEST(WaveSpeeds, ArrestWindowIsABarWavesWayAlongTheLongestExtent) {
  input::Parameters parameters;
  parameters.specimen.size = {0.14, 0.005, 0.0245};
  parameters.materials[0] = {3.3e9, 0.38, 1180};
  EXPECT_DOUBLE_EQ(dynamics::arrest_window(parameters), 0.14 / std::sqrt(3.3e9 / 1180));
  parameters.time.arrest = 3e-6;
  EXPECT_EQ(dynamics::arrest_window(parameters), 3e-6);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::mechanics
