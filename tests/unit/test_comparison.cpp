// SPDX-License-Identifier: GPL-3.0-or-later
// Comparison of ensembles: intervals and p-values by hand, against published examples, and their coverage.
#include "crackle/analysis/comparison.h"
#include "crackle/common/random.h"

#include "support/geometry_bodies.h"

#include <gmock/gmock.h>
#include <boost/math/distributions/normal.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace crackle::analysis {
namespace CRACKLE_TEST_FILE {

TEST(Comparison, PermutationsOfAFewValuesByHand) {
  // Among the 20 ways to choose three of six values, these two have the largest difference.
  EXPECT_DOUBLE_EQ(permutation_probability({{1, 2, 3}, {4, 5, 6}}), 0.1);
  EXPECT_DOUBLE_EQ(permutation_probability({{4, 5, 6}, {1, 2, 3}}), 0.1) << "two-sided";
  // For pairs with differences of one sign, 2 of 2^5 have the largest mean.
  EXPECT_DOUBLE_EQ(permutation_probability({{1, 2, 3, 4, 5}, {2, 4, 6, 5, 8}, true}), 2.0 / 32);
  EXPECT_DOUBLE_EQ(permutation_probability({{1, 1}, {1, 1}}), 1);
  EXPECT_DOUBLE_EQ(permutation_probability({{}, {1}}), 1);
  // One of 126 ways: as Fisher's exact test of 4 of 4 against 0 of 5.
  EXPECT_DOUBLE_EQ(permutation_probability({{1, 1, 1, 1}, {0, 0, 0, 0, 0}}), 1.0 / 126);
}

TEST(Comparison, MeansByHand) {
  // Welch's example with t for 2.0 degrees: {1, 3} and {4, 8}: variances 2 and 8, squared errors 1 and 4,
  // 25 / (1 + 16) = 1.4706 degrees of freedom, for which Student's t at 95 % is 6.2064... (R's qt(0.975, 25 /
  // 17)).
  // By scipy.stats.t with Welch's degrees of freedom.
  const Difference welch = difference_of_means({{1, 3, 2.5, 7.1}, {4, 8, 3.3}}, 0.95);
  EXPECT_DOUBLE_EQ(welch.value, 1.7);
  EXPECT_NEAR(welch.lower, -3.5012378177939056, 1e-9);
  EXPECT_NEAR(welch.upper, 6.901237817793907, 1e-9);
  // For pairs with differences 1, 2 and 6: as in test_statistics for 2 degrees of freedom.
  const Difference paired = difference_of_means({{0, 0, 0}, {1, 2, 6}, true}, 0.95);
  EXPECT_DOUBLE_EQ(paired.value, 3);
  EXPECT_NEAR((paired.upper - paired.lower) / 2, 4.302652729749464 * std::sqrt(7.0 / 3), 1e-10);
  EXPECT_TRUE(std::isnan(difference_of_means({{1}, {2, 3}}, 0.95).lower)) << "one value has no scatter";
}

std::vector<double> ones(int n_ones, int n) {
  std::vector<double> values(static_cast<std::size_t>(n), 0.0);
  std::fill_n(values.begin(), n_ones, 1.0);
  return values;
}

TEST(Comparison, SharesAsInNewcombesTables) {
  // Stat. Med. 17 (1998) 873, table II, method 10: 56/70 - 48/80 is 0.2 (0.0524 to 0.3339).
  const Difference independent = difference_of_shares({ones(48, 80), ones(56, 70)}, 0.95);
  EXPECT_NEAR(independent.value, 0.2, 1e-12);
  EXPECT_NEAR(independent.lower, 0.0524, 5e-5);
  EXPECT_NEAR(independent.upper, 0.3339, 5e-5);
  // 10/10 - 0/20: 0.6791 to 1.
  const Difference extreme = difference_of_shares({ones(0, 20), ones(10, 10)}, 0.95);
  EXPECT_NEAR(extreme.lower, 0.6791, 5e-5);
  EXPECT_NEAR(extreme.upper, 1, 1e-12);
  // For pairs, ibid. 2635: 1 - 1 in all of them has both ends at the ends of Wilson's intervals.
  TwoSamples pairs{ones(0, 10), ones(10, 10), true};
  const Difference paired = difference_of_shares(pairs, 0.95);
  EXPECT_EQ(paired.value, 1);
  EXPECT_EQ(paired.upper, 1);
  EXPECT_LT(paired.lower, 0.7);
}

TEST(Comparison, MediansHaveExactIntervalsOrNone) {
  // From the least to the largest of 6 differences: 1 - 2 / 2^6 = 96.9 %.
  const Difference six = difference_of_medians({{0, 0, 0, 0, 0, 0}, {6, 5, 9, 1, 2, 3}, true}, 0.95);
  EXPECT_EQ(six.value, 4);
  EXPECT_EQ(six.lower, 1);
  EXPECT_EQ(six.upper, 9);
  EXPECT_TRUE(std::isnan(difference_of_medians({{0, 0, 0, 0, 0}, {1, 2, 3, 4, 5}, true}, 0.95).lower));
  EXPECT_TRUE(std::isnan(difference_of_medians({{0, 1, 2, 3, 4}, {1, 2, 3, 4, 5, 6, 7}}, 0.95).lower));
}

TEST(Comparison, EqualValuesHaveNoInterval) {
  const TwoSamples pairs{{1, 2, 4, 5, 6, 7}, {2, 3, 5, 6, 7, 8}, true};
  for (const Difference& found : {difference_of_means(pairs, 0.95), difference_of_medians(pairs, 0.95)}) {
    EXPECT_EQ(found.value, 1);
    EXPECT_TRUE(found.has_no_width);
    EXPECT_TRUE(std::isnan(found.lower) && std::isnan(found.upper));
  }
}

TEST(Comparison, IntervalsOfTiesAreShown) {
  // The means of all draws and the middle order statistics are equal, the values are not.
  const std::vector<std::size_t> draws{0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5};
  const std::vector<double> zero(12, 0.0), one{1, 3, 1, 3, 1, 3, 1, 3, 1, 3, 1, 3};
  const std::vector<double> ties{1, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 3};
  for (const Difference& found :
       {difference_of_means({zero, one, true, draws, draws}, 0.95),
        difference_of_medians({zero, ties, true}, 0.95), difference_of_medians({zero, ties}, 0.95)}) {
    EXPECT_FALSE(found.has_no_width);
    EXPECT_EQ(found.lower, 2);
    EXPECT_EQ(found.upper, 2);
  }
  EXPECT_TRUE(difference_of_medians({zero, std::vector<double>(12, 2.0)}, 0.95).has_no_width);
}

TEST(Comparison, ASingleUnitHasTheVarianceOfTheOthers) {
  // Only these units have a value. Other labels that leave a single one of them on a side do not count as
  // larger differences: {0} and 1 to 6 are 3.5 / sqrt(3.5 + 3.5 / 6) apart, {0, 1, 2} and 3 to 6 more.
  const TwoSamples some{{0, 1, 2}, {3, 4, 5, 6}, false, {0, 1, 2}, {0, 1, 2, 3}};
  const std::vector<std::size_t> groups{0, 1, 2, 3, 4, 5};
  const std::vector<double> equal(6, 1.0);
  const std::vector<TwoSamples> looks{some, {equal, equal, false, groups, groups}};
  EXPECT_DOUBLE_EQ(joint_test(looks, {}).adjusted[0], 60.0 / 924);
}

TEST(Comparison, TheObservedLabelsDoNotDecideWhichLooksCount) {
  // Ten units, of which other labels put up to five on the first side.
  const TwoSamples uneven{{9}, {0, 1, 2, 3, 4, 5, 6, 7, 8}, false, {0}, {0, 1, 2, 3, 4, 5, 6, 7, 8}};
  const std::vector<std::size_t> groups{0, 1, 2, 3, 4, 5, 6, 7, 8};
  const std::vector<double> equal(9, 1.0);
  const std::vector<TwoSamples> looks{uneven, {equal, equal, false, groups, groups}};
  EXPECT_GT(least_probability(uneven), 0.05);
  EXPECT_EQ(joint_test(looks, {}).n_looks, 1);
}

TEST(Comparison, AShiftOfEightPairsIsSignificantBesideManyLooks) {
  // As the first, but for a linear function: counted once. The others do not differ. One has too few values.
  TwoSamples shifted{{}, {}, true}, scaled = shifted;
  std::vector<TwoSamples> others(12, shifted);
  for (int i = 0; i < 8; ++i) {
    shifted.first.push_back(i);
    shifted.second.push_back(i + 20 + std::sin(i));
    scaled.first.push_back(3 * shifted.first.back());
    scaled.second.push_back(3 * shifted.second.back());
    for (std::size_t k = 0; k < others.size(); ++k) {
      others[k].first.push_back(0);
      others[k].second.push_back(std::cos(1 + 2.3 * i * static_cast<double>(k + 1)));
    }
  }
  std::vector<TwoSamples> looks{shifted, scaled};
  looks.insert(looks.end(), others.begin(), others.end());
  looks.push_back({{1, 2, 3}, {4, 7, 9}, true});
  const JointTest found = joint_test(looks, {});
  std::printf("8 pairs, one of 13 looks shifted by 20: p = %.4f of all, least %.4f\n", found.adjusted[0],
              found.least);
  EXPECT_DOUBLE_EQ(found.adjusted[0], 2.0 / 256);
  EXPECT_DOUBLE_EQ(found.adjusted[1], 2.0 / 256);
  EXPECT_EQ(found.same_as[1], 0);
  EXPECT_EQ(found.same_as[2], -1);
  EXPECT_EQ(found.n_looks, 13);
  EXPECT_EQ(found.n_too_small, 1);
  EXPECT_TRUE(std::isnan(found.adjusted.back()));
  EXPECT_DOUBLE_EQ(found.least, 2.0 / 256);
  for (std::size_t k = 2; k < 14; ++k) EXPECT_GE(found.adjusted[k], permutation_probability(looks[k]));
}

TEST(Comparison, TheLeastPossibleProbability) {
  EXPECT_DOUBLE_EQ(least_probability({{1, 2, 3}, {1, 2, 3}}), 0.1);
  EXPECT_DOUBLE_EQ(least_probability({{1, 2}, {1, 2, 3}}), 0.1);
  EXPECT_DOUBLE_EQ(least_probability({{1, 2, 3, 4}, {1, 2, 3, 4}, true}), 0.125);
  EXPECT_DOUBLE_EQ(least_probability({std::vector<double>(50), std::vector<double>(50)}), 1e-4);
  EXPECT_DOUBLE_EQ(least_probability({{1, 2, 3, 4}, {1, 2, 3, 4}, true, {0, 0, 1, 1}}), 0.5) << "two draws";
}

TEST(Comparison, EnergyDistanceByHand) {
  const double none = not_a_number;
  // 2 * 3 - 1 / 2 - 1 / 2 with paths at distances 1 within the groups and 3 between them.
  const EnergyDistance found = energy_distance({{{0}, {1}}, {{3}, {4}}});
  EXPECT_DOUBLE_EQ(found.value, 2 * 3 - 0.5 - 0.5);
  EXPECT_DOUBLE_EQ(found.probability, 2.0 / 6);
  const EnergyDistance same = energy_distance({{{0, 1}, {2, 5}}, {{0, 1}, {2, 5}}});
  EXPECT_NEAR(same.value, 0, 1e-12);
  // The section that one path does not reach is excluded from all its pairs.
  EXPECT_DOUBLE_EQ(energy_distance({{{0, none}, {1, none}}, {{3, 7}, {4, 8}}}).value, 5);
  EXPECT_TRUE(std::isnan(energy_distance({{{0}}, {{3}, {4}}}).value));
  // Differences 1 and 2: |D + D'| is 2, 3, 3 and 4, |D - D'| 0, 1, 1 and 0. Of four sign combinations two are
  // as far apart.
  const EnergyDistance paired = energy_distance({{{0}, {50}}, {{1}, {52}}, true});
  EXPECT_DOUBLE_EQ(paired.value, 2 * (12 - 2) / 4.0);
  EXPECT_DOUBLE_EQ(paired.probability, 0.5);
}

/// Normal numbers, with a different scatter in the second group.
class DrawnComparison : public ::testing::Test {
protected:
  std::vector<double> normal(std::size_t n, double mean, double deviation, std::uint64_t trial,
                             const char* name) {
    RandomStream stream(1, trial, name);
    std::vector<double> values(n);
    const boost::math::normal law(mean, deviation);
    for (double& value : values)
      value = boost::math::quantile(law, 0.5 * std::ldexp(1.0, -52) + stream.uniform());
    return values;
  }
};

TEST_F(DrawnComparison, IntervalsHoldAsOftenAsTheySay) {
  int n_means = 0, n_pairs = 0, n_medians = 0, n_shares = 0, n_significant = 0, n_significant_pairs = 0;
  constexpr int n_trials = 400;
  for (std::uint64_t trial = 0; trial < n_trials; ++trial) {
    const TwoSamples samples{normal(9, 0, 1, trial, "a"), normal(14, 1, 2, trial, "b")};
    const auto holds = [](const Difference& d, double truth) {
      return d.lower <= truth && truth <= d.upper ? 1 : 0;
    };
    n_means += holds(difference_of_means(samples, 0.95), 1);
    n_medians += holds(difference_of_medians(samples, 0.95), 1);
    TwoSamples null{samples.first, samples.second};
    for (double& value : null.second) value -= 1;
    n_significant += permutation_probability(null) <= 0.05 ? 1 : 0;
    // Pairs whose first components share additional scatter.
    TwoSamples pairs{normal(12, 0, 5, trial, "c"), normal(12, 0, 1, trial, "d"), true};
    for (std::size_t i = 0; i < 12; ++i) pairs.second[i] += pairs.first[i];
    n_pairs += holds(difference_of_means(pairs, 0.95), 0);
    n_significant_pairs += permutation_probability(pairs) <= 0.05 ? 1 : 0;
    TwoSamples shares{normal(20, 0, 1, trial, "e"), normal(30, 0, 1, trial, "f")};
    for (double& value : shares.first) value = value > 0.5244 ? 1 : 0;    // a share of 0.3
    for (double& value : shares.second) value = value > -0.2533 ? 1 : 0;  // of 0.6
    n_shares += holds(difference_of_shares(shares, 0.95), 0.3);
  }
  const auto percent = [](int n) { return 100.0 * n / n_trials; };
  std::printf(
      "of 95 %% intervals hold: means %.1f %%, of pairs %.1f %%, medians %.1f %%, shares %.1f %%; below 0.05 "
      "by chance: "
      "%.1f %%, of pairs %.1f %%\n",
      percent(n_means), percent(n_pairs), percent(n_medians), percent(n_shares), percent(n_significant),
      percent(n_significant_pairs));
  for (const int n : {n_means, n_pairs, n_shares}) EXPECT_NEAR(percent(n), 95, 3.3);
  EXPECT_GT(percent(n_medians), 93.5);
  for (const int n : {n_significant, n_significant_pairs}) EXPECT_NEAR(percent(n), 5, 3.3);
}

TEST_F(DrawnComparison, NoneOfManyDependentLooksIsSignificantByChanceTooOften) {
  int n_pairs = 0, n_independent = 0;
  constexpr int n_trials = 300;
  for (std::uint64_t trial = 0; trial < n_trials; ++trial) {
    std::vector<TwoSamples> pairs, independent;
    std::vector<TwoGroupsOfPaths> paths{{{}, {}, true}};
    const auto common = normal(20, 0, 1, trial, "common");
    for (std::size_t look = 0; look < 6; ++look) {
      const auto own =
          normal(20, 0, look < 3 ? 0.1 : 2, trial, std::string("look " + std::to_string(look)).c_str());
      TwoSamples one{{}, {}, true}, other;
      for (std::size_t i = 0; i < 10; ++i) {
        one.first.push_back(common[i] + own[i]);
        one.second.push_back(common[10 + i] + own[10 + i]);
        if (look == 0) paths[0].first.push_back({one.first.back(), own[i]});
        if (look == 0) paths[0].second.push_back({one.second.back(), own[10 + i]});
        if (i < 5) other.first.push_back(one.first.back());
        if (i < 5) other.second.push_back(one.second.back());
      }
      pairs.push_back(one);
      independent.push_back(other);
    }
    const auto any = [](const JointTest& found) {
      return std::ranges::any_of(found.adjusted, [](double p) { return p <= significant; }) ? 1 : 0;
    };
    n_pairs += any(joint_test(pairs, paths));
    n_independent += any(joint_test(independent, {}));
  }
  std::printf("any of 7 dependent looks below 0.05 by chance: %.1f %% of pairs, %.1f %% of independent\n",
              100.0 * n_pairs / n_trials, 100.0 * n_independent / n_trials);
  EXPECT_NEAR(100.0 * n_pairs / n_trials, 5, 3.8);
  EXPECT_NEAR(100.0 * n_independent / n_trials, 5, 3.8);
}

TEST_F(DrawnComparison, ReplicatesAreTakenByWholeDraws) {
  // 8 meshes for each of 7 draws, correlated by 0.8 within draws.
  int n_significant = 0, n_alone = 0, n_means = 0, n_medians = 0, n_shares = 0;
  constexpr int n_trials = 200, n_trials_alone = 40;
  for (std::uint64_t trial = 0; trial < n_trials; ++trial) {
    TwoSamples samples;
    const auto fill = [&](std::vector<double>& values, std::vector<std::size_t>& groups, std::size_t n_draws,
                          const char* name) {
      const auto own = normal(9 * n_draws, 0, 1, trial, name);
      for (std::size_t i = 0; i < 8 * n_draws; ++i) {
        groups.push_back(i / 8);
        values.push_back(std::sqrt(0.8) * own[8 * n_draws + i / 8] + std::sqrt(0.2) * own[i]);
      }
    };
    fill(samples.first, samples.first_group, 7, "a");
    fill(samples.second, samples.second_group, 7, "b");
    const auto holds = [](const Difference& d) { return d.lower <= 0 && 0 <= d.upper ? 1 : 0; };
    n_means += holds(difference_of_means(samples, 0.95));
    n_medians += holds(difference_of_medians(samples, 0.95));
    n_significant += permutation_probability(samples) <= 0.05 ? 1 : 0;
    if (trial < n_trials_alone)
      n_alone += permutation_probability({samples.first, samples.second}) <= 0.05 ? 1 : 0;
    for (auto* values : {&samples.first, &samples.second})
      for (double& value : *values) value = value > 0 ? 1 : 0;
    n_shares += holds(difference_of_shares(samples, 0.95));
  }
  const auto percent = [](int n) { return 100.0 * n / n_trials; };
  std::printf(
      "8 replicates with correlation 0.8: below 0.05 by chance %.1f %% by draws, %.1f %% by samples; of 95 "
      "%% intervals hold: means %.1f %%, medians %.1f %%, shares %.1f %%\n",
      percent(n_significant), 100.0 * n_alone / n_trials_alone, percent(n_means), percent(n_medians),
      percent(n_shares));
  EXPECT_NEAR(percent(n_significant), 5, 4.5);
  EXPECT_GT(100.0 * n_alone / n_trials_alone, 20);
  EXPECT_NEAR(percent(n_means), 95, 4.5);
  EXPECT_GT(percent(n_medians), 91);
  EXPECT_GT(percent(n_shares), 91);
}

TEST_F(DrawnComparison, EnergyDistanceSeesWhatMeansDoNot) {
  int n_same = 0, n_wider = 0;
  constexpr int n_trials = 60;
  for (std::uint64_t trial = 0; trial < n_trials; ++trial) {
    const auto paths = [&](double deviation, const char* name) {
      std::vector<std::vector<double>> group;
      const auto values = normal(90, 0, deviation, trial, name);
      for (std::size_t i = 0; i < 30; ++i)
        group.push_back({values[3 * i], values[3 * i + 1], values[3 * i + 2]});
      return group;
    };
    n_same += energy_distance({paths(1, "a"), paths(1, "b")}).probability <= 0.05 ? 1 : 0;
    n_wider += energy_distance({paths(1, "a"), paths(2, "c")}).probability <= 0.05 ? 1 : 0;
  }
  std::printf("paths told apart: %d of %d from one distribution, %d of %d of twice the scatter\n", n_same,
              n_trials, n_wider, n_trials);
  EXPECT_LE(n_same, 9);
  EXPECT_GE(n_wider, n_trials * 9 / 10);
}

input::Parameters plate() {
  input::Parameters parameters;
  parameters.specimen = {{0.005, 0.02, 0.1}, {crackle::testing::notch(input::Face::y_min, 50, 5, 1)}};
  parameters.sections.y = {0.01, 0.015};
  return parameters;
}

SampleSummary done(double force, int branching_points, std::vector<double> z) {
  SampleSummary row = empty_summary(1, 2, SampleStatus::done);
  row.onset_force = force;
  row.branching_points = branching_points;
  row.position = std::move(z);
  row.leading_start = 0;
  return row;
}

/// Pairs of samples with loads 5 to 5.7 N apart; a pair has failed.
struct Pairs {
  Pairs() {
    for (int i = 0; i < 8; ++i) {
      const double z = 0.05 + 1e-3 * std::sin(7.0 * i);
      first.push_back(done(400 + 40 * std::cos(5.0 * i), 0, {z, z}));
      second.push_back(done(first.back().onset_force + 5 + 0.1 * i, 1, {z + 1e-4, not_a_number}));
    }
    second[3] = empty_summary(1, 2, SampleStatus::failed);
    law.fracture.release = input::Release::facet;
  }

  input::Parameters one = plate(), law = one;
  std::vector<SampleSummary> first, second;
};

/// Loads of which the samples of one ensemble are only loaded so far.
std::vector<SampleSummary> loaded_to(double most, double factor) {
  std::vector<SampleSummary> rows;
  for (int i = 0; i < 40; ++i) {
    const double strength = factor * (400 + 40 * std::cos(5.0 * i));
    rows.push_back(done(strength, 0, {0.05, 0.05}));
    rows.back().outcome = strength < most ? 2 : 0;
    rows.back().peak_load = std::min(strength, most);
    if (strength >= most) rows.back().onset_force = not_a_number;
    rows.back().work_of_fracture = rows.back().peak_load;
  }
  return rows;
}

TEST(Comparison, LoadsOfSamplesThatDidNotBreakAreLowerBounds) {
  const input::Parameters one = plate();
  input::Parameters other = one;
  for (const bool are_paired : {true, false}) {
    if (!are_paired) other.mesh.perturbation = 0.3;
    const auto of_peak = [&](const std::vector<SampleSummary>& first,
                             const std::vector<SampleSummary>& second) {
      const Comparison found = compare({&one, first}, {&other, second});
      EXPECT_EQ(found.are_paired, are_paired);
      std::printf("%s", to_text(found, "a", "b", one.sections).c_str());
      for (const ComparedResult& result : found.results)
        if (std::string(result.info.name) == "work_of_fracture") {
          EXPECT_LT(result.n_first, 40);
        }
      EXPECT_THAT(to_text(found, "a", "b", one.sections), ::testing::HasSubstr("Some samples did not break"));
      return *std::ranges::find(found.results, std::string("peak_load"),
                                [](const ComparedResult& result) { return std::string(result.info.name); });
    };
    // The same strengths: that one ensemble is loaded less is no difference.
    const ComparedResult same = of_peak(loaded_to(410, 1), loaded_to(900, 1));
    EXPECT_EQ(same.n_first, 40);
    EXPECT_GT(same.n_bounds_first, 10);
    EXPECT_EQ(same.n_bounds_second, 0);
    EXPECT_NEAR(same.of_medians.value, 0, 1e-9);
    EXPECT_GT(same.probability, 0.3);
    EXPECT_TRUE(std::isnan(same.mean_first));
    const ComparedResult weaker = of_peak(loaded_to(410, 1), loaded_to(410, 0.93));
    EXPECT_LT(weaker.probability, 0.01);
    EXPECT_NEAR(weaker.of_medians.value, -0.07 * weaker.median_first.value, 1);
  }
}

TEST(Comparison, PairsTheSamplesOfTheSameBodies) {
  const Pairs pairs;
  const auto force_of = [](const Comparison& comparison) {
    return *std::ranges::find(comparison.results, std::string("onset_force"),
                              [](const ComparedResult& result) { return std::string(result.info.name); });
  };
  const Comparison paired = compare({&pairs.one, pairs.first}, {&pairs.law, pairs.second});
  EXPECT_TRUE(paired.are_paired);
  EXPECT_EQ(paired.n_pairs, 7);
  EXPECT_NEAR(force_of(paired).of_means.value, 5 + 0.1 * 25 / 7, 1e-9);
  EXPECT_LT(force_of(paired).of_means.upper, 6);
  EXPECT_DOUBLE_EQ(force_of(paired).probability, 2.0 / 128);
  ASSERT_EQ(paired.paths.size(), 1U);
  EXPECT_NEAR(paired.paths[0].of_means[0].value, 1e-4, 1e-12);
  EXPECT_TRUE(std::isnan(paired.paths[0].of_means[1].value)) << "no crack of the second reaches it";
  EXPECT_GE(force_of(paired).adjusted, force_of(paired).probability);
  std::printf("%s", to_text(paired, "a", "b", pairs.one.sections).c_str());

  input::Parameters mesh = pairs.one;
  mesh.mesh.perturbation = 0.3;
  const Comparison independent = compare({&pairs.one, pairs.first}, {&mesh, pairs.second});
  EXPECT_FALSE(independent.are_paired);
  EXPECT_THAT(independent.note, ::testing::HasSubstr("mesh.perturbation = 0.3"));
  EXPECT_GT(force_of(independent).probability, 0.3);
  EXPECT_EQ(force_of(independent).n_first, 8);
}

TEST(Comparison, RemarksSayWhatTheNumbersHoldFor) {
  const Pairs made;
  const auto& [one, law, first, second] = made;
  const auto remarks_of = [](const Comparison& comparison) {
    std::string all;
    for (const std::string& remark : comparison.remarks) all += remark + "\n";
    return all;
  };
  input::Parameters mesh = one;
  mesh.mesh.perturbation = 0.3;
  EXPECT_THAT(remarks_of(compare({&one, first}, {&mesh, second})),
              ::testing::Not(::testing::HasSubstr("one draw")));
  input::Parameters replicated = law;
  replicated.ensemble.replicates = 2;
  EXPECT_THAT(remarks_of(compare({&one, first}, {&replicated, second})),
              ::testing::HasSubstr("are by whole draws, 4 and 4."));
  EXPECT_THAT(remarks_of(compare({&one, first}, {&law, second})),
              ::testing::HasSubstr("Failed samples are in no number: 0 in the first, 1 in"));
  std::vector<SampleSummary> unfinished = second;
  unfinished[0].outcome = 4;
  EXPECT_THAT(
      remarks_of(compare({&one, first}, {&law, unfinished})),
      ::testing::HasSubstr("Undecided samples count with what they had reached, in all numbers: 0 in the "
                           "first, 1 in the second."));
  EXPECT_THAT(remarks_of(compare({&one, std::span(first).first(3)}, {&law, second})),
              ::testing::HasSubstr("no difference could be significant: the least p is 0.250"));
  const auto with_base = [](input::Parameters parameters, input::Base base) {
    parameters.mesh.base = base;
    return parameters;
  };
  const auto own = with_base(one, input::Base::own), shared = with_base(law, input::Base::shared);
  EXPECT_FALSE(compare({&own, first}, {&own, second}).has_shared_base);
  EXPECT_THAT(
      remarks_of(compare({&own, first}, {&shared, second})),
      ::testing::HasSubstr("hold for the second ensemble's base points only (mesh.base = \"shared\")"));
  EXPECT_THAT(remarks_of(compare({&shared, first}, {&shared, second})),
              ::testing::HasSubstr("hold for these base points only"));
  replicated.random.resize(1);
  replicated.ensemble.plan = input::SamplingPlan::sobol;
  EXPECT_THAT(compare({&one, first}, {&replicated, second}).note,
              ::testing::HasSubstr("lie more evenly than independent ones"));
}

TEST(Comparison, PathsAreComparedInTheSameBodyAtTheSameSections) {
  const Pairs made;
  const auto& [one, law, first, second] = made;
  input::Parameters wider = one;
  wider.specimen.size[1] = 0.021;
  EXPECT_TRUE(compare({&one, first}, {&wider, second}).paths.empty());
  input::Parameters elsewhere = one;
  elsewhere.sections.y = {0.01, 0.016};
  const Comparison other_sections = compare({&one, first}, {&elsewhere, second});
  EXPECT_TRUE(other_sections.are_paired);
  EXPECT_TRUE(other_sections.paths.empty());
  EXPECT_THAT(other_sections.note, ::testing::HasSubstr("sections differ"));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::analysis
