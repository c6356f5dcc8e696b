// SPDX-License-Identifier: GPL-3.0-or-later
// An invalid motion is detected by its energies.
#include "dynamics/energy_account.h"

#include <gmock/gmock.h>

#include <limits>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

EnergyRow row(double time, double kinetic, double external) {
  return {time, kinetic, 0, external, 0, 0, 0};
}

TEST(EnergyFault, NumbersThatAreNone) {
  for (const double wrong :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_THAT(*energy_fault(std::vector{row(1e-6, wrong, 1)}, 200),
                testing::HasSubstr("not finite 1 us after"));
    EXPECT_TRUE(energy_fault(std::vector{row(1e-6, 1, wrong)}, 200));
  }
  EXPECT_FALSE(energy_fault(std::vector{row(1e-6, 1, 1)}, 200));
  EXPECT_FALSE(energy_fault({}, 200));
}

TEST(EnergyFault, MoreThanTheLoadsGave) {
  std::vector<EnergyRow> rows{row(0, 0, 0)};
  while (rows.size() < 19) rows.push_back(row(1e-6, 1e-12, 1e-14));
  EXPECT_FALSE(energy_fault(rows, 200)) << "what rounding makes of almost nothing, at the beginning";
  rows.push_back(row(1e-6, 9, 1));
  EXPECT_FALSE(energy_fault(rows, 200));
  rows.push_back(row(2e-6, 11, 1));
  EXPECT_THAT(
      *energy_fault(rows, 200),
      testing::HasSubstr("2 us after the start of the phase the energy, 11 J, exceeds the supplied 1 J"));
}

TEST(EnergyFault, RoundingOfABodyThatIsHardlyLoaded) {
  std::vector<EnergyRow> rows{row(0, 0, 0)};
  while (rows.size() < 40) rows.push_back(row(1e-6, 1e-18, 0));
  EXPECT_TRUE(energy_fault(rows, 200));
  EXPECT_FALSE(energy_fault(rows, 200, 1e-12));
  rows.push_back(row(1e-6, 1e-11, 0));
  EXPECT_TRUE(energy_fault(rows, 200, 1e-12));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
