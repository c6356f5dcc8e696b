// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/weibull_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

namespace crackle::analysis {
namespace CRACKLE_TEST_FILE {

CensoredValues loads(const std::vector<double>& broken, int n_unbroken = 0, double bound = 0) {
  CensoredValues values;
  for (const double one : broken) values.add({one, false}, values.size());
  for (int i = 0; i < n_unbroken; ++i) values.add({bound, true}, values.size());
  return values;
}

void expect_near(const FittedParameter& found, const FittedParameter& right, double relative) {
  std::cout << found.value << " (" << found.lower << " to " << found.upper << "), reference " << right.value
            << " (" << right.lower << " to " << right.upper << ")\n";
  EXPECT_NEAR(found.value / right.value, 1, relative);
  EXPECT_NEAR(found.lower / right.lower, 1, relative);
  EXPECT_NEAR(found.upper / right.upper, 1, relative);
}

const std::vector<double> ten{52, 61, 66, 70, 73, 77, 80, 84, 88, 95};

// References: tools/crackle/weibull.py, that is NumPy's random numbers.
TEST(WeibullFit, OfKnownValuesHasIntervalsByTheirNumber) {
  const auto fit = weibull_fit(loads(ten), 0.95).value();
  expect_near(fit.modulus, {5.976, 3.435, 10.06}, 0.03);
  expect_near(fit.scale, {79.79, 71.14, 90.12}, 0.004);
  EXPECT_EQ(fit.n_broken, 10);
  EXPECT_EQ(fit.n_unbroken, 0);
}

TEST(WeibullFit, CountsUnbrokenSamplesAsStronger) {
  const auto fit = weibull_fit(loads({ten.begin(), ten.begin() + 7}, 3, 82), 0.95).value();
  expect_near(fit.modulus, {7.01446, 3.31691, 12.51511}, 1e-4);
  expect_near(fit.scale, {79.51479, 71.41024, 92.97588}, 1e-4);
  EXPECT_EQ(fit.n_unbroken, 3);
}

// The interval reaches far where few of many samples broke; reference: SciPy's minimize_scalar and brentq.
TEST(WeibullFit, OfFewBrokenSamplesHasTheWholeInterval) {
  const auto fit = weibull_fit(loads({30, 36, 41, 46, 49}, 995, 50), 0.95).value();
  expect_near(fit.modulus, {4.386337, 1.574002, 9.422625}, 1e-4);
  expect_near(fit.scale, {167.2244, 86.75279, 1505.017}, 1e-4);
}

// ASTM C1239 has a factor of 0.859 for ten values.
TEST(WeibullFit, HasNoBias) {
  const auto fit = weibull_fit(loads(ten), 0.95).value();
  double sum = 0, modulus = 5;
  for (int i = 0; i < 100; ++i) {  // the equation of the most likely modulus, by substitution
    double weights = 0, first = 0, mean = 0;
    for (const double one : ten) {
      weights += std::pow(one, modulus);
      first += std::pow(one, modulus) * std::log(one);
      mean += std::log(one) / 10;
    }
    modulus = 0.5 * (modulus + 1 / (first / weights - mean));
    sum = modulus;
  }
  std::cout << "factor " << fit.modulus.value / sum << '\n';
  EXPECT_NEAR(fit.modulus.value / sum, 0.859, 0.005);
}

TEST(WeibullFit, IsNoneOfTooFewOrEqualValues) {
  EXPECT_FALSE(weibull_fit(loads({1, 2, 3, 4}), 0.95));
  EXPECT_FALSE(weibull_fit(loads({3, 3, 3, 3, 3, 3}), 0.95));
  EXPECT_FALSE(weibull_fit(loads({0, 1, 2, 3, 4, 5}), 0.95));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::analysis
