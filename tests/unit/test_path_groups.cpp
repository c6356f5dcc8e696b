// SPDX-License-Identifier: GPL-3.0-or-later
// Samples whose cracks take different ways: found where they do, not where chance alone scatters them.
#include "analysis/path_groups.h"
#include "analysis/stop_rule.h"
#include "common/random.h"
#include "common/real.h"

#include "support/effort.h"
#include "support/geometry_bodies.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace crackle::analysis {
namespace CRACKLE_TEST_FILE {

constexpr double mm = 1e-3;
constexpr double none = not_a_number;

double normal(RandomStream& random) {
  return std::sqrt(-2 * std::log(1 - random.uniform())) * std::cos(2 * std::numbers::pi * random.uniform());
}

bool is_divided(const std::vector<double>& values) {
  const auto gap = clearest_gap(values);
  return gap && gap->clarity > 1;
}

TEST(PathGroups, SamplesOfOneWayAreRarelyDivided) {
  RandomStream random(1, 0, "ways");
  for (const std::size_t n : {4, 10, 17, 20, 60, 200, 1500}) {
    const int n_trials = n > 1000 ? test::repetitions(500, 2'000) : test::repetitions(10'000, 40'000);
    for (const bool is_uniform : {false, true}) {
      int n_divided = 0;
      std::vector<double> values(n);
      for (int trial = 0; trial < n_trials; ++trial) {
        for (double& value : values) value = 0.05 + mm * (is_uniform ? random.uniform() : normal(random));
        n_divided += is_divided(values) ? 1 : 0;
      }
      const double expected = false_division_rate * n_trials;
      std::printf("%zu %s values: divided %.3f %%\n", n, is_uniform ? "uniform" : "normal",
                  100.0 * n_divided / n_trials);
      EXPECT_LE(n_divided, expected + 3 * std::sqrt(expected));
    }
  }
}

TEST(PathGroups, ClearGroupsAreFound) {
  RandomStream random(2, 0, "ways");
  int n_minorities = 0, n_halves = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> few, half;
    for (int i = 0; i < 20; ++i) {
      few.push_back((i < 2 ? 50 : 55.8) * mm + 0.7 * mm * normal(random));
      half.push_back((i < 10 ? 0 : 8) * mm + mm * normal(random));
    }
    n_minorities += is_divided(few) ? 1 : 0;
    n_halves += is_divided(half) ? 1 : 0;
  }
  std::printf("2 of 20 found in %d of 200, 10 of 20 in %d\n", n_minorities, n_halves);
  EXPECT_GE(n_minorities, 180);
  EXPECT_GE(n_halves, 165);
  EXPECT_TRUE(is_divided({12.50 * mm, 12.58 * mm, 12.61 * mm, 12.66 * mm, 18.3 * mm}));
  EXPECT_FALSE(is_divided({1 * mm, 2 * mm, 9 * mm})) << "too few";
  EXPECT_FALSE(is_divided({1 * mm, 1 * mm, 2 * mm, 2 * mm, 2 * mm})) << "equal positions count once";
  EXPECT_FALSE(clearest_gap({}).has_value());
}

/// Twenty paths: from one place, then 17 above and 3 below, one of which ends before the last section. Sample
/// 0 ends before the ways part, sample 1 reaches no section.
std::vector<std::vector<double>> two_ways() {
  RandomStream random(3, 0, "ways");
  std::vector<std::vector<double>> paths;
  for (int i = 0; i < 22; ++i) {
    const bool is_below = i % 7 == 3;
    const auto at = [&](double above, double below) {
      return (is_below ? below : above) * mm + 0.3 * mm * normal(random);
    };
    paths.push_back({at(50, 50), at(53, 49), at(56, 48)});
  }
  paths[0] = {50 * mm, none, none};
  paths[1] = {none, none, none};
  paths[10][2] = none;
  return paths;
}

TEST(PathGroups, TheyHoldAlongTheWholePath) {
  const auto paths = two_ways();
  const std::vector<int> group = path_groups(paths);
  for (std::size_t i = 0; i < paths.size(); ++i) EXPECT_EQ(group[i], i < 2 ? -1 : i % 7 == 3 ? 0 : 1) << i;
  EXPECT_EQ(path_groups({}), std::vector<int>{});
  EXPECT_EQ(path_groups({{none}, {none}}), (std::vector{-1, -1}));
}

TEST(PathGroups, ThreeWaysAreThreeGroups) {
  RandomStream random(4, 0, "ways");
  std::vector<std::vector<double>> paths;
  for (int i = 0; i < 30; ++i)
    paths.push_back({((i % 3 == 0 ? 40 : i % 3 == 1 ? 8 : 0) + 0.4 * normal(random)) * mm});
  const std::vector<int> group = path_groups(paths);
  for (int i = 0; i < 30; ++i) EXPECT_EQ(group[static_cast<std::size_t>(i)], 2 - i % 3);
}

Statistics statistics_of(const std::vector<std::vector<double>>& paths, double half_width) {
  input::Parameters p;
  p.ensemble.samples = static_cast<int>(paths.size());
  p.ensemble.stop = input::EnsembleStop{half_width, 0.95, p.ensemble.samples};
  p.specimen = {{0.005, 0.04, 0.1}, {crackle::testing::notch(plane::Face::y_min, 50, 5, 1)}};
  p.sections.y = {0.015, 0.02, 0.03};
  std::vector<SampleSummary> rows;
  for (const auto& path : paths) {
    rows.push_back(empty_summary(1, 3, SampleStatus::done));
    rows.back().position = path;
    rows.back().leading_start = 0;
  }
  return make_statistics(rows, p);
}

TEST(PathGroups, StatisticsGiveEachGroupsShareAndMean) {
  const auto paths = two_ways();
  const Statistics found = statistics_of(paths, mm);
  ASSERT_EQ(found.leader.groups.size(), 2U);
  const PathGroup &below = found.leader.groups[0], &above = found.leader.groups[1];
  EXPECT_EQ(below.n, 3);
  EXPECT_EQ(above.n, 17);
  EXPECT_EQ(below.n_of, 21) << "with the one that ends before the ways part";
  EXPECT_DOUBLE_EQ(below.share, 3.0 / 21);
  EXPECT_DOUBLE_EQ(below.share_lower, share_interval(3, 21, 0.95).lower);
  EXPECT_DOUBLE_EQ(below.share_upper, share_interval(3, 21, 0.95).upper);
  EXPECT_THAT(below.reached, ::testing::ElementsAre(3, 3, 2));
  EXPECT_THAT(above.reached, ::testing::ElementsAre(17, 17, 17));
  EXPECT_NEAR(above.z_mean[2], 56 * mm, 0.3 * mm);
  EXPECT_NEAR(below.z_mean[2], 48 * mm, 0.6 * mm);
  EXPECT_NEAR(above.z_half_width[2], student_half_width(above.z_std[2], 17, 0.95), 1e-12);
  EXPECT_THAT(found.leader.is_divided, ::testing::ElementsAre(0, 1, 1)) << "not where they start";
  // The text shows no mean of all there.
  const std::string text = to_text(found, {}, input::Sections{.y = {0.015, 0.02, 0.03}, .z = {}});
  EXPECT_THAT(text, ::testing::HasSubstr("3 of 21"));
  EXPECT_THAT(text, ::testing::ContainsRegex("y = 30 mm +z +19 +groups"));
}

TEST(PathGroups, EnoughSamplesAreThoseThatKnowTheGroups) {
  const Statistics found = statistics_of(two_ways(), mm);
  const auto worst = least_certain(found);
  ASSERT_TRUE(worst);
  EXPECT_EQ(worst->n, 17) << "not that of a group with three samples, nor of all";
  EXPECT_GT(found.leader.z_half_width[2], mm);
  EXPECT_LT(worst->half_width, 0.25 * mm);
  EXPECT_TRUE(is_known(found, 0.25 * mm));
  EXPECT_LT(n_samples_needed(found, 0.1 * mm), 150);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::analysis
