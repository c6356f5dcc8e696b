// SPDX-License-Identifier: GPL-3.0-or-later
// Statistics of a match: closed forms, and their promises on made-up curves.
#include "crackle/common/random.h"
#include "crackle/experiment/group_test.h"
#include "crackle/experiment/path_frame.h"
#include "crackle/experiment/rank_test.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace crackle::experiment {
namespace CRACKLE_TEST_FILE {

using ::testing::Each;
using ::testing::ElementsAre;

ValueTable numbers(const std::vector<double>& values) {
  return {1, values};
}

/// A smooth curve of Gaussian shape coefficients: a random offset, slope and bend at `n` columns.
std::vector<double> curve(RandomStream& stream, double scale = 1, double shift = 0, std::size_t n = 12) {
  const double a = stream.normal(), b = stream.normal(), c = stream.normal();
  std::vector<double> values;
  for (std::size_t k = 0; k < n; ++k) {
    const double s = static_cast<double>(k) / static_cast<double>(n - 1);
    values.push_back(shift + scale * (a + b * s + c * std::sin(2 * std::numbers::pi * s)));
  }
  return values;
}

ValueTable curves(RandomStream& stream, std::size_t n, double scale = 1, double shift = 0) {
  ValueTable table{12, {}};
  for (std::size_t i = 0; i < n; ++i) table.add(curve(stream, scale, shift));
  return table;
}

ValueTable run_collectively(const ValueTable& one, const ValueTable& other) {
  ValueTable both = one;
  both.values.insert(both.values.end(), other.values.begin(), other.values.end());
  return both;
}

TEST(ExperimentDistances, ByHand) {
  const double none = not_a_number;
  EXPECT_DOUBLE_EQ(distance(std::vector{0.0, 3.0}, std::vector{4.0, 6.0}, 9), std::sqrt(25.0 / 2));
  EXPECT_DOUBLE_EQ(distance(std::vector{0.0, none}, std::vector{4.0, 6.0}, 9), std::sqrt((16.0 + 81) / 2))
      << "not arriving is a value";
  EXPECT_DOUBLE_EQ(distance(std::vector{0.0, none}, std::vector{4.0, none}, 9), std::sqrt(16.0 / 2));
  EXPECT_DOUBLE_EQ(largest_difference({2, {0, 5, 3, none, 1, 9}}), 4);
  EXPECT_DOUBLE_EQ(largest_difference({1, {2, 2, none}}), 1) << "something, so that it differs";
  // Distances of 1 and 2 parts in another unit count alike: each has a root mean square of 1.
  const Distances one = distances_of(numbers({0, 1})), other = distances_of(numbers({0, 1000}));
  EXPECT_DOUBLE_EQ(joint_distances(std::vector{one, other})(0, 1), 1);
  EXPECT_THAT(distances_of(numbers({0, 1, 5})).means(), ElementsAre(3, 2.5, 4.5));
}

TEST(RankTest, ByHand) {
  EXPECT_DOUBLE_EQ(rank_p_value(distances_of(numbers({10, 0, 1, 2, 3}))), 1.0 / 5) << "the least there is";
  EXPECT_DOUBLE_EQ(least_p_value(4), 1.0 / 5);
  // Mean distances 7 / 4, 9 / 4 for 0; 2, 6 / 4 for 1; and so on: only 3 is as far out as 0.
  EXPECT_DOUBLE_EQ(rank_p_value(distances_of(numbers({0, 1, 2, 3}))), 2.0 / 4) << "ties count";
  EXPECT_DOUBLE_EQ(rank_p_value(distances_of(numbers({1.5, 0, 1, 2, 3}))), 1);
  EXPECT_EQ(samples_needed(0.05), 19u);
  EXPECT_EQ(samples_needed(0.01), 99u);
  EXPECT_DOUBLE_EQ(least_p_value(samples_needed(0.05)), 0.05);
}

TEST(EnvelopeOfCurves, ByHand) {
  // The columns have the values 1, 2, 3, 5 twice and 0, 1, 2, 3. Row 0 has ranks exp(-2 / 2) twice and 1.5,
  // so an area of 1 - 2 (1 - exp(-1)) / 3 = 0.579; row 1 exp(-1 / 3), 1.5 and exp(-1 / 2), 0.774; row 2
  // 0.906; row 3 0.869.
  const Envelope found = envelope({3, {5, 5, 1, 1, 2, 3, 2, 1, 2, 3, 3, 0}}, 0.5);
  EXPECT_DOUBLE_EQ(found.p_value, 1.0 / 4);
  EXPECT_DOUBLE_EQ(envelope({3, {2, 1, 2, 1, 2, 3, 5, 5, 1, 3, 3, 0}}, 0.5).p_value, 1)
      << "row 2 is the last";
  EXPECT_DOUBLE_EQ(envelope({3, {3, 3, 0, 2, 1, 2, 1, 2, 3, 5, 5, 1}}, 0.5).p_value, 3.0 / 4);
  EXPECT_DOUBLE_EQ(found.level, 0.5);
  EXPECT_THAT(found.lower, ElementsAre(2, 1, 0));
  EXPECT_THAT(found.upper, ElementsAre(3, 3, 2));
  EXPECT_THAT(found.is_outside, ElementsAre(true, true, false));

  const auto with_others = [](const std::vector<double>& row) {
    ValueTable table{2, row};
    for (int i = 0; i < 19; ++i) table.add(std::vector{0.1 * i, 0.1 * ((7 * i + 5) % 19)});
    return table;
  };
  const Envelope band = envelope(with_others({9, 9}), 0.95);
  EXPECT_DOUBLE_EQ(band.level, 0.95);
  EXPECT_DOUBLE_EQ(band.p_value, 1.0 / 20);
  EXPECT_THAT(band.lower, Each(0));
  EXPECT_THAT(band.upper, Each(0.1 * 18));
  EXPECT_THAT(band.is_outside, Each(true));
  EXPECT_DOUBLE_EQ(envelope(with_others({9, 9}), 0.99).level, 0.95) << "more rows were needed";

  const Envelope ended = envelope(with_others({0.9, not_a_number}), 0.95);
  EXPECT_DOUBLE_EQ(ended.p_value, 5.0 / 20)
      << "the only one that ended, and the four at the ends of the others";
  EXPECT_THAT(ended.is_outside, Each(false));
}

TEST(GroupTest, ByHand) {
  // 2 * 3.5 - 0.5 - 16 / 9; of the 10 ways to choose two, {4, 6} is farther apart; by depth six are.
  const GroupTest test = group_test(distances_of(numbers({0, 1, 2, 4, 6})), 2);
  EXPECT_DOUBLE_EQ(test.energy, 7 - 0.5 - 16.0 / 9);
  EXPECT_TRUE(test.are_all);
  EXPECT_EQ(test.n_permutations, 10);
  EXPECT_DOUBLE_EQ(test.energy_p_value, 0.2);
  EXPECT_DOUBLE_EQ(test.depth_p_value, 0.6);
  EXPECT_DOUBLE_EQ(test.p_value(), 0.4);
}

TEST(GroupTest, ManyWaysAreTriedAtRandom) {
  std::vector<double> values{90, 91, 92, 93, 94};
  for (int i = 0; i < 40; ++i) values.push_back(i);
  const GroupTest test = group_test(distances_of(numbers(values)), 5);
  EXPECT_FALSE(test.are_all);
  EXPECT_EQ(test.n_permutations, n_random_permutations + 1);
  EXPECT_LE(test.energy_p_value, 2e-4);
  EXPECT_LE(test.depth_p_value, 2e-4);
}

TEST(Scatter, ByHand) {
  // Variances 2 of the experiments and 5 / 3 of four samples; F(1, 3) from scipy.stats.
  const Scatter found = scatter(numbers({11, 13}), numbers({1, 2, 3, 4}), 0, 0.95);
  EXPECT_DOUBLE_EQ(found.shift.value, 9.5);
  EXPECT_DOUBLE_EQ(found.degrees, 1);
  EXPECT_DOUBLE_EQ(found.ratio.value, std::sqrt(2 / (5.0 / 3)));
  EXPECT_NEAR(found.ratio.lower, std::sqrt(1.2 / 17.4434433), 1e-6);
  EXPECT_NEAR(found.ratio.upper, std::sqrt(1.2 / 1.15718913e-3), 1e-4);
  // An error of reading of variance 1 leaves 1 of 2, and with one of 4 nothing is left to see.
  EXPECT_DOUBLE_EQ(scatter(numbers({11, 13}), numbers({1, 2, 3, 4}), 1, 0.95).ratio.value,
                   std::sqrt(1 / (5.0 / 3)));
  EXPECT_DOUBLE_EQ(scatter(numbers({11, 13}), numbers({1, 2, 3, 4}), 2, 0.95).ratio.value, 0);
}

TEST(Scatter, DegreesOfFreedomAreThoseOfTheCovariance) {
  // Two independent columns of equal variance count twice; the same column twice counts once.
  EXPECT_NEAR(scatter({2, {0, 0, 1, 1}}, {2, {1, 1, 1, -1, -1, 1, -1, -1}}, 0, 0.95).degrees, 2, 1e-12);
  EXPECT_NEAR(scatter({2, {0, 0, 1, 1}}, {2, {1, 1, 2, 2, 3, 3, 7, 7}}, 0, 0.95).degrees, 1, 1e-12);
}

TEST(Scatter, ColumnsThatAreRarelyReachedDoNotCount) {
  const double none = not_a_number;
  const Scatter found = scatter({2, {0, 0, 2, none}}, {2, {1, 1, 2, 2, 3, 3}}, 0, 0.95);
  EXPECT_EQ(found.n_columns, 1u) << "an experiment ended before";
  EXPECT_EQ(found.n_samples, 3u);
  const Scatter half = scatter({2, {0, 0, 2, 1}}, {2, {1, 1, 2, 2, 3, none}}, 0, 0.95);
  EXPECT_EQ(half.n_columns, 1u) << "a third of the samples did";
}

/// Chi-square of the counts of p * (n + 1), in `n_bins` equal bins.
double chi_square(const std::vector<double>& p_values, std::size_t n, std::size_t n_bins) {
  std::vector<double> counts(n_bins, 0);
  for (const double p : p_values) {
    const double rank = std::round(p * static_cast<double>(n + 1)) - 1;
    counts.at(static_cast<std::size_t>(rank * static_cast<double>(n_bins) / static_cast<double>(n + 1))) += 1;
  }
  const double expected = static_cast<double>(p_values.size()) / static_cast<double>(n_bins);
  double sum = 0;
  for (const double count : counts) sum += (count - expected) * (count - expected) / expected;
  return sum;
}

class ValidRankTest : public ::testing::TestWithParam<std::size_t> {};

TEST_P(ValidRankTest, GivesUniformPValuesToLeftOutSamples) {
  const std::size_t n = GetParam();
  RandomStream stream(1, n, "validity");
  std::vector<double> of_distance, of_scaled;
  int n_small_of_band = 0;
  const int n_trials = n == 199 ? 300 : 600;
  for (int trial = 0; trial < n_trials; ++trial) {
    const ValueTable samples = curves(stream, n);
    const ValueTable table = run_collectively(curves(stream, 1), samples);
    of_distance.push_back(rank_p_value(distances_of(table)));
    n_small_of_band += envelope(table, 0.95).p_value <= 0.05 ? 1 : 0;
    of_scaled.push_back(rank_p_value(distances_of(run_collectively(curves(stream, 1, 3), samples))));
  }
  const std::size_t n_bins = n == 50 ? 17 : 20;  // divisors of n + 1
  const double limit = n == 50 ? 39.3 : 43.8;    // chi-square at 0.001
  fmt::print(
      "n = {}: chi-square of {} p-values {:.1f}, below {:.1f} in 999 of 1000 cases; band at 0.05 left by {} "
      "%\n",
      n, n_trials, chi_square(of_distance, n, n_bins), limit, 100.0 * n_small_of_band / n_trials);
  EXPECT_LT(chi_square(of_distance, n, n_bins), limit);
  EXPECT_GT(chi_square(of_scaled, n, n_bins), limit) << "a wrong experiment is seen";
  // 0.05 and three standard errors.
  EXPECT_LT(n_small_of_band, n_trials * (0.05 + 3 * std::sqrt(0.05 * 0.95 / n_trials)));
  EXPECT_GT(n_small_of_band, 0);
}

INSTANTIATE_TEST_SUITE_P(Samples, ValidRankTest, ::testing::Values(19, 50, 199));

TEST(ValidGroupTest, HasItsLevelAndThePowerThatItPromises) {
  constexpr std::size_t m = 5, n = 40;
  constexpr int n_trials = 150;
  RandomStream stream(2, 0, "validity");
  const double deviation = std::sqrt(1 + 1.0 / 3 + 0.5);  // of curve(), averaged over the columns
  int by_chance = 0, of_shift = 0, of_scatter = 0;
  const auto is_found = [&](const ValueTable& experiments, const ValueTable& samples) {
    return group_test(distances_of(run_collectively(experiments, samples)), m, 199).p_value() <= 0.05 ? 1 : 0;
  };
  for (int trial = 0; trial < n_trials; ++trial) {
    const ValueTable samples = curves(stream, n);
    by_chance += is_found(curves(stream, m), samples);
    of_shift += is_found(curves(stream, m, 1, deviation), samples);
    of_scatter += is_found(curves(stream, m, 2), samples);
  }
  EXPECT_LT(by_chance, n_trials * (0.05 + 3 * std::sqrt(0.05 * 0.95 / n_trials)));
  const Power promised = power(curves(stream, n + m), m, n_trials);
  fmt::print(
      "found by chance in {:.1f} %, a shift in {:.0f} % ({:.0f} promised), twice the scatter in {:.0f} % "
      "({:.0f})\n",
      100.0 * by_chance / n_trials, 100.0 * of_shift / n_trials, 100 * promised.of_shift,
      100.0 * of_scatter / n_trials, 100 * promised.of_scatter);
  // Three standard errors of the difference of two shares, and the chance of these samples.
  constexpr double tolerance = 3 * 0.5 * 0.115 + 0.05;
  EXPECT_NEAR(promised.of_shift, of_shift / static_cast<double>(n_trials), tolerance);
  EXPECT_NEAR(promised.of_scatter, of_scatter / static_cast<double>(n_trials), tolerance);
  EXPECT_GT(of_shift, n_trials / 4);
  EXPECT_GT(of_scatter, n_trials / 4);
  EXPECT_EQ(power(curves(stream, 6), 5, 10).n_trials, 0) << "too few to take out";
}

TEST(ValidScatter, IntervalsCoverTheTruth) {
  constexpr std::size_t m = 5, n = 50;
  constexpr int n_trials = 600;
  constexpr double true_ratio = 1.5, true_shift = 0.7, error = 0.5;
  RandomStream stream(3, 0, "validity");
  int n_ratio = 0, n_shift = 0;
  for (int trial = 0; trial < n_trials; ++trial) {
    ValueTable experiments = curves(stream, m, true_ratio, true_shift);
    for (double& value : experiments.values) value += error * stream.normal();
    const Scatter found = scatter(experiments, curves(stream, n), error, 0.9);
    n_ratio += found.ratio.lower <= true_ratio && true_ratio <= found.ratio.upper ? 1 : 0;
    n_shift += found.shift.lower <= true_shift && true_shift <= found.shift.upper ? 1 : 0;
  }
  fmt::print("90 % intervals cover the ratio in {:.1f} %, the shift in {:.1f} %\n",
             100.0 * n_ratio / n_trials, 100.0 * n_shift / n_trials);
  // 90 % and three standard errors; Box's distribution is an approximation.
  const double tolerance = 3 * std::sqrt(0.9 * 0.1 / n_trials) + 0.02;
  EXPECT_NEAR(n_ratio / static_cast<double>(n_trials), 0.9, tolerance);
  EXPECT_NEAR(n_shift / static_cast<double>(n_trials), 0.9, tolerance);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::experiment
