// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/random.h"
#include "parallel/agreement.h"
#include "parallel/exact_sum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace crackle::parallel {
namespace CRACKLE_TEST_FILE {

double sum_of(const std::vector<double>& terms) {
  ExactSum sum;
  for (const double term : terms) sum.add(term);
  return sum.value();
}

TEST(ExactSum, KeepsWhatPlainSummationLoses) {
  EXPECT_EQ(sum_of({1e100, 1, -1e100}), 1);
  EXPECT_EQ(sum_of({1, 1e-300, -1}), 1e-300);
  EXPECT_EQ(sum_of({-5e-324, -5e-324}), -1e-323);
  EXPECT_EQ(sum_of({}), 0);
  EXPECT_EQ(sum_of({-0.75}), -0.75);
}

TEST(ExactSum, ReproducesSingleTerms) {
  RandomStream stream(7, 0, "exact sum");
  for (int i = 0; i < 20000; ++i) {
    const double term = std::ldexp(stream.uniform(-1, 1), static_cast<int>(stream.uniform(-1060, 1020)));
    EXPECT_EQ(sum_of({term}), term);
  }
}

TEST(ExactSum, DoesNotDependOnTheOrder) {
  RandomStream stream(8, 0, "exact sum");
  std::vector<double> terms;
  for (int i = 0; i < 10000; ++i)
    terms.push_back(std::ldexp(stream.uniform(-1, 1), static_cast<int>(stream.uniform(-60, 60))));
  const double forward = sum_of(terms);
  std::ranges::reverse(terms);
  EXPECT_EQ(sum_of(terms), forward);
  std::ranges::sort(terms);
  EXPECT_EQ(sum_of(terms), forward);
}

TEST(ExactSum, IsWithinOneUnitInTheLastPlace) {
  RandomStream stream(9, 0, "exact sum");
  long double reference = 0;
  std::vector<double> terms;
  for (int i = 0; i < 1000; ++i) {
    terms.push_back(std::floor(stream.uniform(-1e9, 1e9)) / 1024);  // exact in long double
    reference += terms.back();
  }
  EXPECT_NEAR(sum_of(terms), static_cast<double>(reference),
              std::abs(static_cast<double>(reference)) * 2.3e-16);
}

TEST(ExactSum, RefusesTermsThatAreNotFinite) {
  ExactSum sum;
  EXPECT_THROW(sum.add(std::numeric_limits<double>::quiet_NaN()), std::domain_error);
  EXPECT_THROW(sum.add(std::numeric_limits<double>::infinity()), std::domain_error);
  const Communicator self(MPI_COMM_SELF);
  EXPECT_THROW(exact_sum(self, std::vector<double>{1, std::nan("")}), AgreedError);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::parallel
