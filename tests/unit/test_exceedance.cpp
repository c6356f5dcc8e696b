// SPDX-License-Identifier: GPL-3.0-or-later
// The share of samples beyond a limit, and what it leaves out.
#include "analysis/exceedance.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace crackle::analysis {
namespace CRACKLE_TEST_FILE {

using ::testing::HasSubstr;

input::Parameters ensemble(int samples, int replicates = 1) {
  input::Parameters parameters;
  parameters.ensemble.samples = samples;
  parameters.ensemble.replicates = replicates;
  return parameters;
}

SampleSummary done(double load) {
  SampleSummary row = empty_summary(1, 1, SampleStatus::done);
  row.peak_load = load;
  return row;
}

TEST(Exceedance, CountsSamplesAndKnowsThatReplicatesAreAlike) {
  // Replicates with equal values: as many independent samples as draws.
  std::vector<SampleSummary> alike;
  for (int i = 0; i < 64; ++i) alike.push_back(done(i / 2 % 4 == 0 ? 600 : 400));
  const auto parameters = ensemble(64, 2);
  const Exceedance of_draws = exceedance("peak_load > 0.5 kN", alike, 2);
  EXPECT_EQ(of_draws.share.n_hits, 16);
  EXPECT_EQ(of_draws.n_values, 64);
  const auto expected = wilson_interval(0.25, 32, 0.95);
  EXPECT_NEAR(of_draws.share.interval.lower, expected.centre - expected.half_width, 1e-12);
  EXPECT_NEAR(of_draws.share.interval.upper, expected.centre + expected.half_width, 1e-12);
  EXPECT_EQ(exceedance("peak_load<500 N", alike, 2).share.n_hits, 48);
  EXPECT_EQ(to_text(of_draws).substr(0, 45), "peak_load > 500 N: 16 of 64 samples, 25.0 % (");
  EXPECT_EQ(to_text(of_draws).find("planned"), std::string::npos) << "nothing is left out";
  for (const char* const wrong : {"peak_load 500 N", "peak_load >= 500 N", "outcome == 2", "peak > 500 N",
                                  "peak_load > 500", "peak_load > 5 mm", ""})
    EXPECT_THROW(exceedance(wrong, alike, 2), std::runtime_error) << wrong;
}

TEST(Exceedance, SaysWhatTheShareLeavesOut) {
  std::vector<SampleSummary> rows(24, done(600));
  rows[3].outcome = 4;
  rows.insert(rows.end(), 8, empty_summary(1, 1, SampleStatus::failed));
  rows.insert(rows.end(), 30, empty_summary(1, 1, SampleStatus::pending));
  rows.insert(rows.end(), 2, done(not_a_number));
  const Exceedance found = exceedance("peak_load > 500 N", rows);
  EXPECT_EQ(found.n_planned, 64);
  EXPECT_EQ(found.n_failed, 8);
  EXPECT_EQ(found.n_missing, 30);
  EXPECT_EQ(found.n_without, 2);
  const std::string text = to_text(found);
  EXPECT_THAT(text, HasSubstr("24 of 24 samples, 100.0 % (86.2 to 100.0 %), 1 of them undecided\n"));
  EXPECT_THAT(text,
              HasSubstr("of 64 planned 8 failed, 30 are missing and 2 have no such result: the share is not "
                        "of them; with them it lies between 37.5 and 100.0 %"));
}

SampleSummary unbroken(double load) {
  SampleSummary row = done(load);
  row.outcome = static_cast<std::int32_t>(dynamics::Outcome::unbroken);
  row.work_of_fracture = 1;
  return row;
}

/// Strengths of 1 to 64 N; what is loaded to 36.5 N only does not break above.
std::vector<SampleSummary> bars(bool all_break) {
  std::vector<SampleSummary> rows;
  for (int i = 0; i < 64; ++i) {
    const double strength = (i * 19) % 64 + 1;
    rows.push_back(all_break || strength < 36.5 ? done(strength) : unbroken(36.5));
    rows.back().first_break_load = rows.back().onset_force =
        is_unbroken(rows.back()) ? not_a_number : strength;
  }
  return rows;
}

TEST(Exceedance, CountsSamplesThatDidNotBreakAsStronger) {
  const auto rows = bars(false), all = bars(true);
  for (const char* const condition :
       {"peak_load > 36.5 N", "peak_load < 36.5 N", "first_break_load > 20 N", "onset_force > 3 N"}) {
    const Exceedance found = exceedance(condition, rows);
    const Exceedance expected = exceedance(condition, all);
    EXPECT_EQ(found.share.n_hits, expected.share.n_hits) << condition;
    EXPECT_EQ(found.share.share, expected.share.share);
    EXPECT_EQ(found.share.interval.upper, expected.share.interval.upper);
    EXPECT_EQ(found.n_without, 0);
  }
  EXPECT_THAT(to_text(exceedance("peak_load > 36.5 N", rows)),
              HasSubstr("28 of 64 samples, 43.8 % (32.3 to 55.9 %), 28 of them by lower bounds\n"));
  EXPECT_EQ(exceedance("work_of_fracture > 0.5 J", rows).n_values, 0);
  // Nobody knows how many would have held 50 N.
  const Exceedance beyond = exceedance("peak_load > 50 N", rows);
  EXPECT_TRUE(std::isnan(beyond.share.share));
  EXPECT_EQ(beyond.share.least, 0);
  EXPECT_EQ(beyond.share.most, 28 / 64.0);
  EXPECT_EQ(beyond.share.interval.lower, 0);
  EXPECT_NEAR(beyond.share.interval.upper, 0.559, 0.001);
  EXPECT_THAT(
      to_text(beyond),
      HasSubstr("0.0 to 43.8 % of 64 samples (0.0 to 55.9 %): 28 bore all that was applied, which was less"));
}

/// A crack has run and arrested in them, and they bear more than what they were loaded to at the end.
TEST(Exceedance, CountsHeldSamplesAsStronger) {
  auto rows = bars(false);
  const auto expected = exceedance("peak_load > 36.5 N", bars(true));
  for (SampleSummary& row : rows) {
    if (!is_unbroken(row)) continue;
    row.outcome = static_cast<std::int32_t>(dynamics::Outcome::arrested);
    row.first_break_load = 20;
    row.onset_force = 30;
  }
  EXPECT_EQ(exceedance("peak_load > 36.5 N", rows).share.n_hits, 0) << "as if their peaks were known";
  for (SampleSummary& row : rows)
    row.held = row.outcome == static_cast<std::int32_t>(dynamics::Outcome::arrested) ? 1 : 0;
  for (const char* const condition : {"peak_load > 36.5 N", "onset_force > 36.5 N"}) {
    const Exceedance found = exceedance(condition, rows);
    EXPECT_EQ(found.share.n_hits, expected.share.n_hits) << condition;
    EXPECT_EQ(found.n_bounds, 28) << condition;
  }
  // They did break, and where they first did is known.
  EXPECT_EQ(exceedance("first_break_load > 19 N", rows).n_bounds, 0);
  EXPECT_EQ(exceedance("first_break_load > 19 N", rows).n_values, 64);
  EXPECT_EQ(exceedance("work_of_fracture > 0.5 J", rows).n_values, 0);
}

TEST(Exceedance, FromRestNoSampleHasAnOnsetThatCouldBeBounded) {
  std::vector<SampleSummary> rows(6, done(600));
  rows.resize(12, unbroken(700));
  EXPECT_EQ(exceedance("onset_force > 500 N", rows).n_values, 0);
  EXPECT_EQ(exceedance("peak_load > 500 N", rows).share.n_hits, 12);
}

/// Remissions in weeks under 6-mercaptopurine (Freireich et al. 1963), as in textbooks; negative: bounds.
CensoredValues remissions(int times = 1) {
  CensoredValues values;
  std::size_t group = 0;
  for (const double one :
       {-6, 6, 6, 6, 7, -9, -10, 10, -11, 13, 16, -17, -19, -20, 22, 23, -25, -32, -32, -34, -35}) {
    for (int k = 0; k < times; ++k) values.add({std::abs(one), one < 0}, group);
    ++group;
  }
  return values;
}

TEST(CensoredValues, AreTheTextbooks) {
  const CensoredValues values = remissions();
  const auto above = [&](double limit) { return censored_share(values, limit, true, 0.95); };
  EXPECT_NEAR(above(7).share, 0.8067, 5e-5);
  EXPECT_NEAR(above(22).share, 0.5378, 5e-5);
  EXPECT_NEAR(above(23).share, 0.4482, 5e-5);
  EXPECT_NEAR(censored_share(values, 22, false, 0.95).share, 1 - 0.6275, 5e-5) << "not yet at 22";
  EXPECT_EQ(above(22).n_unknown, 7);
  EXPECT_EQ(above(22).n_hits, 6);
  // Standard error 0.1282.
  const auto wilson = wilson_interval(0.5378, 0.5378 * 0.4622 / (0.1282 * 0.1282), 0.95);
  EXPECT_NEAR(above(22).interval.lower, wilson.centre - wilson.half_width, 2e-4);
  EXPECT_NEAR(above(22).interval.upper, wilson.centre + wilson.half_width, 2e-4);
  EXPECT_TRUE(std::isnan(above(40).share));
  EXPECT_EQ(censored_quantile(values, 0.5).value, 23);
  EXPECT_FALSE(censored_quantile(values, 0.5).is_bound);
  EXPECT_TRUE(censored_quantile(values, 0.75).is_bound);
  EXPECT_EQ(censored_quantile(values, 0).value, 6);
  EXPECT_FALSE(censored_quantile(values, 0).is_bound);
  CensoredValues with_early_bound = values;
  with_early_bound.add({5, true}, 99);
  EXPECT_EQ(censored_quantile(with_early_bound, 0).value, 5);
  EXPECT_TRUE(censored_quantile(with_early_bound, 0).is_bound) << "it may lie below the first that is known";
  const auto [lower, upper] = censored_median_interval(values, 0.95);
  EXPECT_EQ(lower.value, 13);
  EXPECT_FALSE(lower.is_bound);
  EXPECT_TRUE(upper.is_bound);
  // Three equal replicates of each are no more than one.
  const CensoredShare thrice = censored_share(remissions(3), 22, true, 0.95);
  EXPECT_NEAR(thrice.share, above(22).share, 1e-12);
  EXPECT_NEAR(thrice.interval.upper - thrice.interval.lower,
              above(22).interval.upper - above(22).interval.lower, 0.02);
}

TEST(CensoredValues, BelowTheBoundsAreAsIfAllWereKnown) {
  CensoredValues some, all;
  for (std::size_t i = 0; i < 64; ++i) {
    const double value = static_cast<double>((i * 19) % 64) + 1;
    all.add({value}, i);
    some.add({std::min(value, 36.5), value > 36.5}, i);
  }
  EXPECT_EQ(censored_quantile(some, 0.5).value, censored_quantile(all, 0.5).value);
  EXPECT_FALSE(censored_quantile(some, 0.5).is_bound);
  EXPECT_TRUE(censored_quantile(some, 0.75).is_bound);
  EXPECT_EQ(censored_quantile(some, 0.75).value, 36.5);
  const auto found = censored_median_interval(some, 0.95), expected = censored_median_interval(all, 0.95);
  EXPECT_EQ(found[0].value, expected[0].value);
  EXPECT_EQ(expected[1].value, 41);
  EXPECT_TRUE(found[1].is_bound && found[1].value == 36.5);
}

TEST(CensoredValues, ScoresByHand) {
  CensoredValues first, second;
  for (const double value : {1.0, 3.0}) first.add({value}, 0);
  first.add({2, true}, 1);
  for (const double value : {2.0, 3.0}) second.add({value}, 0);
  const auto [one, other] = censored_scores(first, second);
  EXPECT_THAT(one, ::testing::ElementsAre(-4, 2, 2)) << "3 is above 1 and 2; > 2 above 1 and 2";
  EXPECT_THAT(other, ::testing::ElementsAre(1 - 3, 2));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::analysis
