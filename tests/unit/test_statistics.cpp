// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/statistics.h"
#include "common/index.h"
#include "cracks/crack_pattern.h"

#include "support/geometry_bodies.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace crackle::analysis {
namespace CRACKLE_TEST_FILE {

using namespace cracks;

constexpr double none = std::numeric_limits<double>::quiet_NaN();

plane::Specimen one_notch() {
  return {{0.005, 0.02, 0.1}, {crackle::testing::notch(plane::Face::y_min, 50, 5, 1)}};
}

SampleSummary done(std::vector<double> z, Pattern pattern = Pattern::one_crack, double force = 400) {
  SampleSummary row = empty_summary(1, static_cast<int>(z.size()), SampleStatus::done);
  row.position = std::move(z);
  row.pattern = static_cast<std::int32_t>(pattern);
  row.leading_start = 0;
  row.onset_force = force;
  return row;
}

TEST(Statistics, MeanDeviationAndHalfWidthByHand) {
  const std::vector<SampleSummary> samples{done({1}), done({2}), done({4})};
  const Statistics s = make_statistics(samples, 1, 1);
  // Mean 7/3; squares 16/9 + 1/9 + 25/9; Student's t for 2 degrees of freedom and 95 % is 4.302652729749464.
  const double deviation = std::sqrt(42.0 / 9 / 2);
  const double half_width = 4.302652729749464 * deviation / std::sqrt(3.0);
  std::printf("mean %.15g std %.15g half width %.15g (%.15g)\n", s.z_mean[0], s.z_std[0], s.z_half_width[0],
              half_width);
  EXPECT_DOUBLE_EQ(s.z_mean[0], 7.0 / 3);
  EXPECT_DOUBLE_EQ(s.z_std[0], deviation);
  EXPECT_NEAR(s.z_half_width[0], half_width, 1e-10);
  EXPECT_EQ(s.reached[0], 3);
  EXPECT_EQ(s.n_done, 3);
  EXPECT_THAT(s.z_quantile, ::testing::ElementsAre(1, 1.5, 2, 3, 4));
  EXPECT_THAT(s.running_mean, ::testing::ElementsAre(1, 1.5, 7.0 / 3));
}

TEST(Statistics, ConfidenceSetsTheWidth) {
  const std::vector<SampleSummary> samples{done({1}), done({2}), done({4})};
  // t for 2 degrees of freedom: 2.919985580353726 at 90 %, 9.924843200918293 at 99 %.
  const double unit = std::sqrt(42.0 / 9 / 2) / std::sqrt(3.0);
  EXPECT_NEAR(make_statistics(samples, 1, 1, 0.9).z_half_width[0] / unit, 2.919985580353726, 1e-9);
  EXPECT_NEAR(make_statistics(samples, 1, 1, 0.99).z_half_width[0] / unit, 9.924843200918293, 1e-9);
  EXPECT_EQ(make_statistics(samples, 1, 1, 0.9).confidence, 0.9);
  for (const double wrong : {0.0, 1.0, -1.0, none}) {
    EXPECT_THROW(make_statistics(samples, 1, 1, wrong), std::invalid_argument);
  }
}

TEST(Statistics, TheInputSetsShapeAndConfidence) {
  input::Parameters parameters;
  parameters.specimen = one_notch();
  parameters.sections.y = {0.007};
  parameters.ensemble.samples = 3;
  const std::vector<SampleSummary> samples{done({1}), done({2}), done({4})};
  EXPECT_EQ(make_statistics(samples, parameters).confidence, 0.95);
  parameters.ensemble.stop = input::EnsembleStop{1e-4, 0.9, 3};
  const Statistics s = make_statistics(samples, parameters);
  EXPECT_EQ(s.confidence, 0.9);
  EXPECT_EQ(s.n_looks, 1);
  EXPECT_EQ(s.z_half_width, make_statistics(samples, 1, 1, 0.9).z_half_width);
  // Two looks, at two and three samples, share the error probability.
  parameters.ensemble.stop->min_samples = 2;
  const Statistics shared = make_statistics(samples, parameters);
  EXPECT_EQ(shared.n_looks, 2);
  EXPECT_EQ(shared.n_needed, 3);
  EXPECT_EQ(shared.z_half_width, make_statistics(samples, 1, 1, 0.95).z_half_width);
  EXPECT_EQ(shared.pattern_half_width, s.pattern_half_width);
  parameters.ensemble.stop->half_width = 10;
  EXPECT_EQ(make_statistics(samples, parameters).n_needed, 2);
}

TEST(Statistics, OfTracesAreOverTheSamplesThatCrossThePlane) {
  input::Parameters parameters;
  parameters.specimen = one_notch();
  parameters.sections.planes = {{{}, {1, 0, 0}}};
  parameters.ensemble.samples = 4;
  std::vector<SampleSummary> samples;
  for (const double length : {1.0, 0.0, 2.0, 4.0}) {
    samples.push_back(done({}));
    // Of the notch, of cracks without a start, of all.
    const StartTrace trace = length > 0 ? StartTrace{length, 10 * length, -length, 0} : StartTrace{};
    samples.back().traces = {trace, {}, trace};
  }
  const Statistics s = make_statistics(samples, parameters);
  ASSERT_EQ(s.traces.size(), 3U);
  EXPECT_EQ(s.traces[1].n_crossed, 0);
  EXPECT_TRUE(std::isnan(s.traces[1].results[0].mean));
  const TraceStatistics& found = s.traces[0];
  EXPECT_EQ(found.n_crossed, 3);
  EXPECT_EQ(found.n_of, 4);
  EXPECT_EQ(found.share, 0.75);
  EXPECT_EQ(found.interval.lower, share_interval(3, 4, 0.95).lower);
  const auto& [length, along, across, time] =
      std::tie(found.results[0], found.results[1], found.results[2], found.results[3]);
  EXPECT_DOUBLE_EQ(length.mean, 7.0 / 3);
  EXPECT_DOUBLE_EQ(length.std, std::sqrt(42.0 / 9 / 2));
  EXPECT_NEAR(length.half_width, 4.302652729749464 * length.std / std::sqrt(3.0), 1e-10);
  EXPECT_DOUBLE_EQ(along.mean, -7.0 / 3);
  EXPECT_EQ(across.std, 0);
  EXPECT_DOUBLE_EQ(time.mean, 70.0 / 3);
  // Whole draws of two samples.
  parameters.ensemble.replicates = 2;
  EXPECT_GT(make_statistics(samples, parameters).traces[0].results[0].half_width, length.half_width);
}

TEST(Statistics, DeviationsOfEqualValuesAreZero) {
  // The squares and the squared sum cancel to the last bit.
  std::vector<SampleSummary> samples;
  for (int i = 0; i < 7; ++i) samples.push_back(done({0.065123456789}));
  EXPECT_EQ(make_statistics(samples, 1, 1).z_std[0], 0);
  samples.push_back(done({0.065123456789 + 1e-12}));
  const double expected = 1e-12 / std::sqrt(8.0);
  EXPECT_NEAR(make_statistics(samples, 1, 1).z_std[0] / expected, 1, 1e-4);
}

TEST(Statistics, OfAnEnsembleThatStoppedTheSurplusIsLeftOut) {
  input::Parameters parameters;
  parameters.specimen = one_notch();
  parameters.sections.y = {0.007};
  parameters.ensemble.samples = 5;
  parameters.ensemble.stop = input::EnsembleStop{20, 0.9, 2};
  std::vector<SampleSummary> samples{done({1}), done({2}), done({4}),
                                     empty_summary(1, 1, SampleStatus::pending), done({9})};
  const Statistics s = make_statistics(samples, parameters);
  EXPECT_EQ(s.n_needed, 2);
  EXPECT_EQ(s.n_done, 2);
  EXPECT_EQ(s.z_mean[0], 1.5);
  EXPECT_THAT(s.running_mean, ::testing::ElementsAre(1, 1.5, 1.5, 1.5, 1.5));
  const input::Sections sections{.y = {0.007}, .z = {}};
  leave_out_surplus(s, 0, samples);
  EXPECT_EQ(samples[1].status, SampleStatus::done);
  for (const int i : {2, 3, 4}) EXPECT_EQ(samples[index(i)].status, SampleStatus::pending);
  const std::string text = to_text(s, samples, sections);
  EXPECT_THAT(text, ::testing::HasSubstr(
                        "2 samples: 2 done, 0 failed, 0 pending\nstopped early: these samples suffice, 5"));
  EXPECT_THAT(text, ::testing::HasSubstr("90 % confidence over 3 tests"));
}

TEST(Statistics, OfAnEnsembleThatEndedElsewhereAreOverItsSamples) {
  input::Parameters parameters;
  parameters.ensemble.samples = 5;
  parameters.ensemble.stop = input::EnsembleStop{100, 0.9, 2};
  parameters.specimen = one_notch();
  parameters.sections.y = {0.007};
  const std::vector<SampleSummary> samples{done({1}), done({2}), done({4}), done({7}),
                                           empty_summary(1, 1, SampleStatus::pending)};
  ASSERT_EQ(make_statistics(samples, parameters).n_needed, 2) << "the rule alone";
  for (const int n_needed : {3, 5}) {
    const Statistics s = make_statistics(samples, parameters, n_needed);
    EXPECT_EQ(s.n_needed, n_needed);
    EXPECT_EQ(s.n_looks, 3);
    EXPECT_EQ(s.n_done, n_needed == 3 ? 3 : 4);
    EXPECT_EQ(s.z_mean[0], n_needed == 3 ? 7.0 / 3 : 14.0 / 4);
  }
  EXPECT_THROW(make_statistics(samples, parameters, 6), std::invalid_argument);
}

TEST(Statistics, OnlyDoneSamplesThatArrivedCount) {
  std::vector<SampleSummary> samples{empty_summary(2, 2, SampleStatus::pending), done({3, none, 5, none}),
                                     empty_summary(2, 2, SampleStatus::failed, "broke"),
                                     done({none, none, 7, none}), done({4, none, 9, 1})};
  samples[2].position = {100, 100, 100, 100};  // values of a failed sample are ignored
  samples[2].pattern = 2;
  const Statistics s = make_statistics(samples, 2, 2);
  EXPECT_EQ(s.n_samples, 5);
  EXPECT_EQ(s.n_done, 3);
  EXPECT_THAT(s.reached, ::testing::ElementsAre(2, 0, 3, 1));
  ASSERT_EQ(s.z_quantile.size(), 20u);
  EXPECT_EQ(s.z_quantile[2], 3.5);
  EXPECT_TRUE(std::isnan(s.z_quantile[7]));
  EXPECT_EQ(s.z_quantile[12], 7);
  EXPECT_EQ(s.z_mean[0], 3.5);
  EXPECT_TRUE(std::isnan(s.z_mean[1]));
  EXPECT_EQ(s.z_mean[2], 7);
  EXPECT_EQ(s.z_std[2], 2);
  EXPECT_EQ(s.z_mean[3], 1);
  for (const auto& of : {s.z_std, s.z_half_width}) {
    EXPECT_TRUE(std::isnan(of[1]));
    EXPECT_TRUE(std::isnan(of[3]));  // a single value has no deviation
  }
  EXPECT_THAT(s.running_mean, ::testing::ElementsAre(::testing::IsNan(), ::testing::IsNan(),
                                                     ::testing::IsNan(), ::testing::IsNan(),        //
                                                     3, ::testing::IsNan(), 5, ::testing::IsNan(),  //
                                                     3, ::testing::IsNan(), 5, ::testing::IsNan(),  //
                                                     3, ::testing::IsNan(), 6, ::testing::IsNan(),  //
                                                     3.5, ::testing::IsNan(), 7, 1));
  EXPECT_THAT(s.pattern_share, ::testing::ElementsAre(0, 1, 0, 0));
}

TEST(Statistics, WilsonIntervalsOfShares) {
  std::vector<SampleSummary> samples;
  for (int i = 0; i < 10; ++i) samples.push_back(done({1}, i < 5 ? Pattern::one_crack : Pattern::two_cracks));
  const Statistics s = make_statistics(samples, 1, 1);
  // Wilson's 95 % interval of 5 in 10 is 0.2366 to 0.7634, that of 0 in 10 is 0 to 0.2775.
  std::printf("5 of 10: +- %.6f, 0 of 10: +- %.6f\n", s.pattern_half_width[1], s.pattern_half_width[0]);
  EXPECT_EQ(s.pattern_share[1], 0.5);
  EXPECT_NEAR(s.pattern_half_width[1], (0.7634 - 0.2366) / 2, 1e-4);
  EXPECT_NEAR(s.pattern_half_width[0], 0.2775 / 2, 1e-4);
  EXPECT_NEAR(s.pattern_lower[1], 0.2366, 1e-4);
  EXPECT_NEAR(s.pattern_upper[1], 0.7634, 1e-4);
  EXPECT_EQ(s.pattern_lower[0], 0);
  EXPECT_NEAR(s.pattern_upper[0], 0.2775, 1e-4);
  // 8 of 20: 0.2188 to 0.6134, which is not centred on 0.4.
  std::vector<SampleSummary> twenty;
  for (int i = 0; i < 20; ++i) twenty.push_back(done({1}, i < 8 ? Pattern::one_crack : Pattern::other));
  EXPECT_NEAR(make_statistics(twenty, 1, 1).pattern_lower[1], 0.2188, 1e-4);
  EXPECT_NEAR(make_statistics(twenty, 1, 1).pattern_upper[1], 0.6134, 1e-4);
  samples.resize(5);
  EXPECT_EQ(make_statistics(samples, 1, 1).pattern_upper[1], 1);
}

TEST(Statistics, WithoutSamplesEverythingIsMissing) {
  const std::vector<SampleSummary> samples(3, empty_summary(1, 2, SampleStatus::pending));
  const Statistics s = make_statistics(samples, 1, 2);
  EXPECT_EQ(s.n_done, 0);
  for (const auto& of : {s.z_mean, s.z_std, s.z_half_width, s.running_mean}) {
    EXPECT_THAT(of, ::testing::Each(::testing::IsNan()));
  }
  EXPECT_THAT(s.pattern_share, ::testing::Each(::testing::IsNan()));
  EXPECT_THAT(s.pattern_half_width, ::testing::Each(::testing::IsNan()));
  EXPECT_THAT(s.pattern_lower, ::testing::Each(::testing::IsNan()));
  EXPECT_THAT(s.pattern_upper, ::testing::Each(::testing::IsNan()));
  EXPECT_EQ(s.running_mean.size(), 6u);
}

TEST(Statistics, RowsOfAnotherShapeAreRefused) {
  EXPECT_THROW(make_statistics(std::vector{done({1, 2})}, 1, 1), std::invalid_argument);
  std::vector<SampleSummary> strange{done({1})};
  strange[0].pattern = 4;
  EXPECT_THROW(make_statistics(strange, 1, 1), std::invalid_argument);
}

TEST(Statistics, QuantilesAreLinearBetweenRanks) {
  EXPECT_EQ(quantile({3, 1, 2, none}, 0.5), 2);
  EXPECT_EQ(quantile({4, 1, 2, 3}, 0.25), 1.75);
  EXPECT_EQ(quantile({4, 1, 2, 3}, 0), 1);
  EXPECT_EQ(quantile({4, 1, 2, 3}, 1), 4);
  EXPECT_TRUE(std::isnan(quantile({none}, 0.5)));
}

TEST(Statistics, TableNamesEverySectionAndEveryFailure) {
  std::vector<SampleSummary> samples{done({0.0661, none}, Pattern::one_crack, 380.9),
                                     done({0.0663, none}, Pattern::two_cracks, 382.1),
                                     empty_summary(1, 2, SampleStatus::failed, "tetrahedron 7 is inverted"),
                                     empty_summary(1, 2, SampleStatus::pending)};
  const input::Sections sections{.y = {0.007}, .z = {0.01225}};
  const std::string text = to_text(make_statistics(samples, 1, 2), samples, sections);
  std::printf("%s", text.c_str());
  EXPECT_THAT(text, ::testing::HasSubstr("4 samples: 2 done, 1 failed, 1 pending"));
  EXPECT_THAT(text, ::testing::ContainsRegex("0 +y = 7 mm +z +2 +66\\.200 +0\\.141 +1\\.271"));
  EXPECT_THAT(text, ::testing::HasSubstr("\nno crack reaches z = 12.25 mm\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex("one crack +50\\.0 +9\\.5 to 90\\.5"));
  EXPECT_THAT(text, ::testing::ContainsRegex("onset force \\[N\\] +380\\.900 +381\\.200 +381\\.500"));
  EXPECT_THAT(text, ::testing::HasSubstr("failed sample 2: tetrahedron 7 is inverted"));
  EXPECT_THAT(text, ::testing::HasSubstr("\nfailed and pending samples are in no number below\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex("onset force .* +382\\.100 +2 +too few samples\n"));
  EXPECT_THAT(text, ::testing::Not(::testing::HasSubstr("undecided: still")));
}

TEST(Statistics, UndecidedSamplesAndEqualValuesAreNamed) {
  std::vector<SampleSummary> samples(6, done({0.0661}));
  samples[1].outcome = samples[2].outcome = 4;
  const std::string text = to_text(make_statistics(samples, 1, 1), samples, {.y = {0.007}, .z = {}});
  EXPECT_THAT(text,
              ::testing::HasSubstr("\n2 undecided: still breaking at the end; all numbers below count"));
  EXPECT_THAT(text, ::testing::Not(::testing::HasSubstr("in no number")));
  EXPECT_THAT(text, ::testing::ContainsRegex("y = 7 mm +z +6 +66\\.100 +0\\.000 +all equal"));
  EXPECT_THAT(text, ::testing::ContainsRegex("onset force .* +400\\.00 +6 +all equal\n"));
  samples.resize(12, samples.back());
  samples.front().onset_force = 300;
  const auto text_of = [&] {
    return to_text(make_statistics(samples, 1, 1), samples, {.y = {0.007}, .z = {}});
  };
  EXPECT_THAT(text_of(), ::testing::ContainsRegex("onset force .* +400 +12 +400 to 400\n"));
  for (SampleSummary& sample : samples) sample.onset_force *= 1e-6;
  EXPECT_THAT(text_of(),
              ::testing::ContainsRegex("onset force \\[uN\\] .* +400\\.0 +12 +400\\.0 to 400\\.0\n"));
}

TEST(Statistics, ReplicatesCountByWholeDraws) {
  input::Parameters parameters;
  parameters.specimen = one_notch();
  parameters.sections.y = {0.007};
  parameters.ensemble.samples = 6;
  parameters.ensemble.replicates = 2;
  parameters.mesh.base = input::Base::own;
  std::vector<SampleSummary> samples;
  for (const double z : {1, 1, 2, 2, 4, 4})
    samples.push_back(done({z}, z < 3 ? Pattern::one_crack : Pattern::other));
  const Statistics s = make_statistics(samples, parameters);
  // As of three samples.
  const std::vector<SampleSummary> three{done({1}), done({2}), done({4})};
  EXPECT_NEAR(s.z_half_width[0], make_statistics(three, 1, 1).z_half_width[0], 1e-12);
  EXPECT_EQ(s.pattern_lower[1], share_interval(2, 3, 0.95).lower);
  EXPECT_THAT(interval_scope(s.base, s.replicates),
              ::testing::HasSubstr("The 2 samples of one draw of the random inputs are not independent"));
  EXPECT_THAT(interval_scope(s.base, s.replicates),
              ::testing::Not(::testing::HasSubstr(" independent samples")));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::analysis
