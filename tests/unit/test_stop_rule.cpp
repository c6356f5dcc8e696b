// SPDX-License-Identifier: GPL-3.0-or-later
// Ensembles that stop early: their interval must keep its confidence despite repeated looks.
#include "analysis/running_statistics.h"
#include "analysis/stop_rule.h"
#include "common/random.h"

#include "support/effort.h"
#include "support/geometry_bodies.h"

#include <gmock/gmock.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numeric>

namespace crackle::analysis {
namespace CRACKLE_TEST_FILE {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

input::Parameters parameters(int samples, double half_width, std::size_t n_sections = 1) {
  input::Parameters p;
  p.ensemble.samples = samples;
  p.ensemble.stop = input::EnsembleStop{half_width, 0.95, 30};
  p.specimen = {{0.005, 0.02, 0.1}, {crackle::testing::notch(plane::Face::y_min, 50, 5, 1)}};
  p.sections.y.assign(n_sections, 0.01);
  return p;
}

SampleSummary row(std::vector<double> z) {
  SampleSummary summary = empty_summary(1, static_cast<int>(z.size()), SampleStatus::done);
  summary.position = std::move(z);
  summary.leading_start = 0;
  return summary;
}

/// Bit patterns, so that NaN equals NaN.
std::vector<std::uint64_t> bits(const std::vector<double>& values) {
  std::vector<std::uint64_t> result;
  for (const double value : values) result.push_back(std::bit_cast<std::uint64_t>(value));
  return result;
}

double normal(RandomStream& random) {
  return std::sqrt(-2 * std::log(1 - random.uniform())) * std::cos(2 * M_PI * random.uniform());
}

TEST(StopRule, LooksGrowByHalf) {
  EXPECT_THAT(look_schedule(200, 30), ::testing::ElementsAre(30, 45, 68, 102, 153, 200));
  EXPECT_THAT(look_schedule(200, 2), ::testing::ElementsAre(2, 3, 5, 8, 12, 18, 27, 41, 62, 93, 140, 200));
  EXPECT_THAT(look_schedule(20, 30), ::testing::ElementsAre(20));
  EXPECT_THAT(look_schedule(30, 30), ::testing::ElementsAre(30));
}

TEST(StopRule, SaysHowManySamplesAHalfWidthTakes) {
  // At the second section every other sample arrives, with larger deviation; at the third hardly any.
  const auto p = parameters(40, 0.1, 3);
  std::vector<SampleSummary> rows;
  for (int i = 0; i < 40; ++i)
    rows.push_back(row({0.1 * (i % 4), i % 2 == 0 ? 0.5 * (i % 4 - 1) : none, i < 2 ? 10.0 * i : none}));
  const Statistics found = make_statistics(rows, p);
  ASSERT_TRUE(least_certain(found));
  EXPECT_EQ(least_certain(found)->position, 1U);
  const double confidence = 1 - 0.05 / found.n_looks;
  int n = 2;
  while (student_half_width(found.leader.z_std[1], n, confidence) > 0.1) ++n;
  std::printf("deviation %.4f: %d values, %.1f samples\n", found.leader.z_std[1], n,
              n_samples_needed(found, 0.1));
  EXPECT_GE(n_samples_needed(found, 0.1), 2 * n);
  EXPECT_LE(n_samples_needed(found, 0.1), 1.02 * 2 * n + 2);
  EXPECT_FALSE(is_known(found, 0.1));
  EXPECT_TRUE(is_known(found, found.leader.z_half_width[1]));
  EXPECT_TRUE(std::isnan(n_samples_needed(make_statistics({}, 1, 3), 0.1)));
}

TEST(StopRule, AMeanOfASingleDrawIsNotKnown) {
  input::Parameters p = parameters(4, 1, 2);
  p.ensemble.stop.reset();
  p.ensemble.replicates = 2;
  const Statistics found =
      make_statistics(std::vector{row({0.1, 0.2}), row({0.2, 0.4}), row({0.3, none}), row({0.4, none})}, p);
  ASSERT_EQ(found.leader.reached[1], 2);
  ASSERT_TRUE(least_certain(found));
  EXPECT_EQ(least_certain(found)->position, 1U);
  EXPECT_FALSE(is_known(found, 1000));
  EXPECT_TRUE(std::isnan(n_samples_needed(found, 1000)));
}

TEST(StopRule, TheOrderOfFinishingPlaysNoPart) {
  const int n = 120;
  const auto p = parameters(n, 0.25, 2);
  RandomStream random(1, 0, "test");
  std::vector<SampleSummary> rows;
  for (int i = 0; i < n; ++i) rows.push_back(row({normal(random), i % 3 == 0 ? none : 0.3 * normal(random)}));
  rows[7] = empty_summary(1, 2, SampleStatus::failed, "broke");
  const Statistics expected = make_statistics(rows, p);
  std::printf("stops at %d of %d, half widths %.4f and %.4f\n", expected.n_needed, n,
              expected.z_half_width[0], expected.z_half_width[1]);
  ASSERT_LT(expected.n_needed, n);
  EXPECT_EQ(expected.n_done, expected.n_needed - 1);

  std::vector<std::size_t> order(n);
  for (int trial = 0; trial < 20; ++trial) {
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = order.size(); i-- > 1;) std::swap(order[i], order[random.bits() % (i + 1)]);
    RunningStatistics running(p);
    for (const std::size_t i : order) {
      const auto before = running.stopped_at();
      running.add(i, rows[i]);
      EXPECT_TRUE(!before || running.stopped_at() == before);
    }
    EXPECT_EQ(running.stopped_at(), static_cast<std::size_t>(expected.n_needed));
    const Statistics found = running.statistics();
    EXPECT_EQ(found.z_mean, expected.z_mean);
    EXPECT_EQ(found.z_std, expected.z_std);
    EXPECT_EQ(found.z_quantile, expected.z_quantile);
    EXPECT_EQ(found.z_half_width, expected.z_half_width);
    EXPECT_EQ(bits(found.running_mean), bits(expected.running_mean));
    EXPECT_EQ(running.leader_position(1).mean, expected.leader.z_mean[1]);
  }
}

TEST(StopRule, WaitsForEarlierSamples) {
  RunningStatistics running(parameters(100, 10));
  for (std::size_t i = 1; i < 60; ++i) running.add(i, row({0.01 * static_cast<double>(i)}));
  EXPECT_EQ(running.stopped_at(), std::nullopt);
  running.add(0, row({0}));
  EXPECT_EQ(running.stopped_at(), 30u);
}

TEST(StopRule, EverySectionThatIsOftenReachedMustBeKnown) {
  const auto p = parameters(400, 0.2, 2);
  const auto stops_at = [&](double deviation, int every) {
    RandomStream random(2, 0, "test");
    RunningStatistics running(p);
    for (std::size_t i = 0; i < 400; ++i) {
      const double other = deviation * normal(random);
      running.add(i, row({0.1 * normal(random), i % static_cast<std::size_t>(every) == 0 ? other : none}));
    }
    return running.statistics().n_needed;
  };
  EXPECT_EQ(stops_at(0.1, 1), 30);
  EXPECT_GT(stops_at(1, 1), 100);
  EXPECT_EQ(stops_at(100, 1), 400);
  EXPECT_EQ(stops_at(100, 20), 30);  // a crack in 5 % of the samples does not count
  RunningStatistics never(p);
  for (std::size_t i = 0; i < 400; ++i) never.add(i, row({none, none}));
  EXPECT_EQ(never.statistics().n_needed, 400) << "without cracks nothing is known";
}

/// Share of ensembles whose interval contains the true mean 0, and the mean number of samples at the end.
std::pair<double, double> coverage(const std::function<double(RandomStream&)>& draw, int trials) {
  const auto p = parameters(500, 0.25);
  int n_hold = 0;
  double n_samples = 0;
  for (int trial = 0; trial < trials; ++trial) {
    RandomStream random(3, static_cast<std::uint64_t>(trial), "coverage");
    RunningStatistics running(p);
    for (std::size_t i = 0; i < 500 && !running.stopped_at(); ++i) running.add(i, row({draw(random)}));
    const Statistics end = running.statistics();
    if (std::abs(end.z_mean[0]) <= end.z_half_width[0]) ++n_hold;
    n_samples += end.n_needed;
  }
  return {static_cast<double>(n_hold) / trials, n_samples / trials};
}

TEST(StopRule, KeepsItsConfidence) {
  struct Case {
    const char* name;
    std::function<double(RandomStream&)> draw;
  };
  const std::vector<Case> cases{
      {"normal", [](auto& r) { return normal(r); }},
      {"two groups",
       [](auto& r) { return r.uniform() < 0.3 ? 1.4 + 0.3 * normal(r) : -0.6 + 0.3 * normal(r); }},
      {"skewed", [](auto& r) { return -std::log(1 - r.uniform()) - 1; }},
  };
  const int trials = test::repetitions(250, 1500);
  for (const Case& c : cases) {
    const auto [held, n_samples] = coverage(c.draw, trials);
    const double error = std::sqrt(0.95 * 0.05 / trials);
    std::printf("%-11s coverage %.4f, nominal 0.95 (standard error %.4f); %.0f samples\n", c.name, held,
                error, n_samples);
    EXPECT_GT(held, 0.95 - 2.5 * error) << c.name;
  }
}

TEST(StopRule, LookingAfterEverySampleWithoutCorrectionWouldNot) {
  // Why the schedule of looks is needed: with a plain interval at every look, some look is wrong too often.
  const int trials = test::repetitions(100, 400);
  int n_hold = 0;
  for (int trial = 0; trial < trials; ++trial) {
    RandomStream random(4, static_cast<std::uint64_t>(trial), "naive");
    Moments moments;
    bool hold = true;
    for (int i = 0; i < 500; ++i) {
      moments.add(normal(random));
      if (i < 29) continue;
      const double half_width = 1.96 * moments.standard_deviation() / std::sqrt(moments.count());
      hold = hold && std::abs(moments.mean()) <= half_width;
    }
    if (hold) ++n_hold;
  }
  const double held = static_cast<double>(n_hold) / trials;
  std::printf("plain intervals at 471 looks all hold in %.3f of the cases, nominal 0.95\n", held);
  EXPECT_LT(held, 0.85);

  // With the schedule the intervals of all looks hold jointly.
  n_hold = 0;
  for (int trial = 0; trial < trials; ++trial) {
    RandomStream random(4, static_cast<std::uint64_t>(trial), "naive");
    std::vector<SampleSummary> rows;
    for (int i = 0; i < 500; ++i) rows.push_back(row({normal(random)}));
    bool hold = true;
    for (const std::size_t n : look_schedule(500, 30)) {
      const auto p = parameters(500, 1e-9);
      RunningStatistics running(p);
      for (std::size_t i = 0; i < n; ++i) running.add(i, rows[i]);
      const Statistics s = running.statistics();
      hold = hold && std::abs(s.z_mean[0]) <= s.z_half_width[0];
    }
    if (hold) ++n_hold;
  }
  const double together = static_cast<double>(n_hold) / trials;
  std::printf("the schedule's intervals all hold in %.3f of the cases\n", together);
  EXPECT_GT(together, 0.95 - 2.5 * std::sqrt(0.95 * 0.05 / trials));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::analysis
