// SPDX-License-Identifier: GPL-3.0-or-later
// Means, shares and medians of values in groups: by hand, and how often their intervals hold.
#include "analysis/grouped_values.h"
#include "common/random.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>

namespace crackle::analysis {
namespace CRACKLE_TEST_FILE {

TEST(GroupedValues, VarianceComponentsByHand) {
  // Group means 2 and 6, within squares 2 and 2: mean square within 2, between 2 * (4 + 4) = 16.
  const std::vector<double> values{1, 3, 5, 7};
  const std::vector<std::size_t> groups{0, 0, 1, 1};
  const VarianceComponents found = variance_components(values, groups);
  EXPECT_EQ(found.n_groups, 2);
  EXPECT_DOUBLE_EQ(found.within, 2);
  EXPECT_DOUBLE_EQ(found.between, (16 - 2) / 2.0);
  EXPECT_DOUBLE_EQ(found.intraclass, 7.0 / 9);
  EXPECT_DOUBLE_EQ(found.design_effect, 1 + 7.0 / 9);
  EXPECT_TRUE(std::isnan(variance_components(values, {}).within)) << "every value alone";
}

TEST(GroupedValues, MeansOfGroupsByHand) {
  // Sums of residuals from 4 are -4 and 4: 2 / 1 * (16 + 16) / 4^2.
  GroupedMoments moments;
  for (const auto& [value, group] : {std::pair{1.0, 0}, {3.0, 0}, {5.0, 1}}) moments.add(value, group);
  EXPECT_EQ(moments.n_groups(), 2);
  moments.add(7, 1);
  EXPECT_DOUBLE_EQ(moments.mean(), 4);
  EXPECT_DOUBLE_EQ(moments.square_error(), 4);
  GroupedMoments alone;
  for (const std::size_t i : {0, 1, 2}) alone.add(std::pow(2, i), i);
  EXPECT_DOUBLE_EQ(alone.square_error(), 7.0 / 9) << "the squared standard error of 1, 2 and 4";
  const std::vector<double> values{1, 3, 5, 7};
  const std::vector<std::size_t> groups{0, 0, 1, 1};
  EXPECT_DOUBLE_EQ(mean_estimate(values, groups, 0.95).half_width, 2 * student_quantile(2, 0.95));
  EXPECT_DOUBLE_EQ(mean_estimate(values, {}, 0.95).half_width,
                   student_half_width(std::sqrt(20.0 / 3), 4, 0.95));
}

TEST(GroupedValues, MediansHaveIntervalsOfOrderStatistics) {
  EXPECT_EQ(least_values_for_median(0.95), 6);
  EXPECT_EQ(least_values_for_median(0.9), 5);
  std::vector<double> values;
  for (int i = 1; i <= 20; ++i) values.push_back(i);
  // Tables of the sign test: of 20 values the 6th and the 15th, 95.9 %.
  const Interval found = median_interval(values, {}, 0.95);
  EXPECT_EQ(found.lower, 6);
  EXPECT_EQ(found.upper, 15);
  EXPECT_TRUE(std::isnan(median_interval(std::span(values).first(5), {}, 0.95).lower));
  // Five draws of four meshes are five values.
  std::vector<std::size_t> draws;
  for (std::size_t i = 0; i < 20; ++i) draws.push_back(i / 4);
  EXPECT_TRUE(std::isnan(median_interval(values, draws, 0.95).lower));
}

TEST(GroupedValues, IntervalsOfMediansHoldAtEverySmallNumber) {
  constexpr int n_trials = 2000;
  std::printf("95 %% intervals of the median of n exponential values hold:");
  for (const std::size_t n : {6, 7, 8, 10, 13, 20}) {
    int n_held = 0;
    for (std::uint64_t trial = 0; trial < n_trials; ++trial) {
      RandomStream stream(1, trial, "median");
      std::vector<double> values(n);
      for (double& value : values) value = -std::log(1 - stream.uniform());
      const Interval found = median_interval(values, {}, 0.95);
      n_held += found.lower <= std::log(2) && std::log(2) <= found.upper ? 1 : 0;
    }
    std::printf(" %zu: %.1f %%", n, 100.0 * n_held / n_trials);
    EXPECT_GE(100.0 * n_held / n_trials, 94);
  }
  std::printf("\n");
}

TEST(GroupedValues, IntervalsOfMediansOfFewDrawsAreNotReversed) {
  // One value of each draw is below the median, so that the share below does not vary.
  const std::vector<std::size_t> draws{0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5};
  const Interval even =
      median_interval(std::vector<double>{1, 7, 2, 8, 3, 9, 4, 10, 5, 11, 6, 12}, draws, 0.95);
  EXPECT_EQ(even.lower, 6);
  EXPECT_EQ(even.upper, 7);
  // Draws that are wholly alike are six values.
  const Interval alike =
      median_interval(std::vector<double>{1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6}, draws, 0.95);
  EXPECT_EQ(alike.lower, 1);
  EXPECT_EQ(alike.upper, 6);
  constexpr int n_trials = 2000;
  std::printf("95 %% intervals of the median of 6 draws of 2 replicates hold, by the draws' share:");
  for (const double share : {0.0, 0.5, 0.9}) {
    int n_held = 0;
    for (std::uint64_t trial = 0; trial < n_trials; ++trial) {
      RandomStream stream(2, trial, "median");
      std::vector<double> values(12);
      for (std::size_t i = 0; i < 12; i += 2) {
        const double draw = std::sqrt(share) * stream.normal();
        for (const std::size_t k : {i, i + 1}) values[k] = draw + std::sqrt(1 - share) * stream.normal();
      }
      const Interval found = median_interval(values, draws, 0.95);
      EXPECT_LE(found.lower, found.upper);
      n_held += found.lower <= 0 && 0 <= found.upper ? 1 : 0;
    }
    std::printf(" %.1f: %.1f %%", share, 100.0 * n_held / n_trials);
    EXPECT_GE(100.0 * n_held / n_trials, 93);
  }
  std::printf("\n");
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::analysis
