// SPDX-License-Identifier: GPL-3.0-or-later
// Several shared bases: how often intervals for the material hold.
#include "analysis/bases.h"
#include "common/random.h"
#include "input/reader.h"

#include "support/geometry_bodies.h"

#include <gmock/gmock.h>
#include <boost/math/distributions/normal.hpp>

#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace crackle::analysis {
namespace CRACKLE_TEST_FILE {

using ::testing::HasSubstr;

input::Parameters plate(std::uint64_t seed) {
  input::Parameters parameters;
  parameters.specimen = {{0.005, 0.02, 0.1}, {crackle::testing::notch(plane::Face::y_min, 50, 5, 1)}};
  parameters.sections.y = {0.01};
  parameters.mesh.base = input::Base::shared;
  parameters.seed = seed;
  return parameters;
}

/// Loads with a mean of 400 N, and the given share of their variance between bases.
std::vector<SampleSummary> rows_of(std::uint64_t trial, std::uint64_t base, int n, double intraclass) {
  RandomStream stream = RandomStream(1, trial, "bases").substream(base);
  const auto normal = [&] {
    return boost::math::quantile(boost::math::normal(), stream.uniform() + std::ldexp(1.0, -54));
  };
  const double mean = 400 + 10 * std::sqrt(intraclass) * normal();
  std::vector<SampleSummary> rows;
  for (int i = 0; i < n; ++i) {
    SampleSummary row = empty_summary(1, 1, SampleStatus::done);
    row.onset_force = mean + 10 * std::sqrt(1 - intraclass) * normal();
    row.leading_start = 0;
    row.position = {0.05};
    rows.push_back(row);
  }
  return rows;
}

const MeanOverBases& of(const BasesStatistics& all, const std::string& name) {
  for (const MeanOverBases& one : all.results)
    if (one.info.name == name) return one;
  throw std::runtime_error("no " + name);
}

TEST(Bases, IntervalsHoldForTheMaterial) {
  constexpr int n_trials = 300, n_bases = 4, n = 40;
  constexpr double intraclass = 0.16;  // as found for the onset of the paper's plate
  int n_material = 0, n_samples = 0;
  double mean_intraclass = 0;
  std::vector<input::Parameters> parameters;
  for (std::uint64_t b = 0; b < n_bases; ++b) parameters.push_back(plate(b));
  for (std::uint64_t trial = 0; trial < n_trials; ++trial) {
    std::vector<std::vector<SampleSummary>> rows;
    std::vector<BaseSamples> bases;
    Moments all;
    for (std::uint64_t b = 0; b < n_bases; ++b) rows.push_back(rows_of(trial, b, n, intraclass));
    for (std::size_t b = 0; b < n_bases; ++b) bases.push_back({&parameters[b], {}, rows[b], {}});
    for (const auto& base : rows)
      for (const SampleSummary& row : base) all.add(row.onset_force);
    const BasesStatistics statistics = statistics_of_bases(bases);
    const MeanOverBases& found = of(statistics, "onset_force");
    n_material += found.mean.lower <= 400 && 400 <= found.mean.upper ? 1 : 0;
    n_samples +=
        std::abs(all.mean() - 400) <= student_half_width(all.standard_deviation(), all.count(), 0.95) ? 1 : 0;
    mean_intraclass += found.variance.intraclass / n_trials;
  }
  std::printf(
      "%d bases of %d samples: 95 %% intervals hold for the material %.1f %%, of independent samples "
      "%.1f %%; intraclass correlation %.3f (%.2f)\n",
      n_bases, n, 100.0 * n_material / n_trials, 100.0 * n_samples / n_trials, mean_intraclass, intraclass);
  EXPECT_NEAR(100.0 * n_material / n_trials, 95, 3.8);
  EXPECT_LT(100.0 * n_samples / n_trials, 75);
  EXPECT_NEAR(mean_intraclass, intraclass, 0.04);
}

TEST(Bases, MeansByHandAndEqualValues) {
  const auto one = plate(1), other = plate(2);
  const auto first = rows_of(1, 1, 3, 0.1), second = rows_of(1, 2, 5, 0.1);
  const std::vector<BaseSamples> bases{{&one, {}, first, {}}, {&other, {}, second, {}}};
  const BasesStatistics all = statistics_of_bases(bases);
  const MeanOverBases& found = of(all, "onset_force");
  EXPECT_DOUBLE_EQ(found.mean.value, (found.of_base[0] + found.of_base[1]) / 2);
  EXPECT_NEAR(found.mean.upper - found.mean.value,
              12.706204736174694 * std::abs(found.of_base[1] - found.of_base[0]) / 2, 1e-9);
  EXPECT_EQ(found.n_values, 8);
  EXPECT_TRUE(of(all, "position").mean.has_no_width);
  const std::string text = to_text(all, one.sections);
  std::printf("%s", text.c_str());
  EXPECT_THAT(text, HasSubstr("2 bases, of seeds 1, 2: 8 samples done, 0 failed, 0 pending\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex("leader, start 0, y = 10 mm \\[mm\\] +8 +50.000 +all equal"));
}

TEST(Bases, WhatDidNotBreakIsInNoMeanOfLoads) {
  const auto one = plate(1), other = plate(2);
  auto first = rows_of(1, 1, 3, 0.1);
  const auto second = rows_of(1, 2, 5, 0.1);
  first[1].outcome = 0;
  first[1].peak_load = first[1].work_of_fracture = 1e6;
  first[1].onset_force = not_a_number;
  const BasesStatistics all =
      statistics_of_bases(std::vector<BaseSamples>{{&one, {}, first, {}}, {&other, {}, second, {}}});
  EXPECT_EQ(of(all, "onset_force").n_values, 7);
  EXPECT_THROW(of(all, "work_of_fracture"), std::runtime_error);
  EXPECT_THROW(of(all, "peak_load"), std::runtime_error);
  EXPECT_THAT(to_text(all, one.sections), HasSubstr("1 samples did not break"));
}

TEST(Bases, HeldSamplesAreNamed) {
  const auto one = plate(1), other = plate(2);
  auto first = rows_of(1, 1, 3, 0.1);
  const auto second = rows_of(1, 2, 5, 0.1);
  first[1].held = 1;
  const BasesStatistics all =
      statistics_of_bases(std::vector<BaseSamples>{{&one, {}, first, {}}, {&other, {}, second, {}}});
  EXPECT_EQ(of(all, "onset_force").n_values, 7);
  EXPECT_EQ(all.n_held, 1);
  EXPECT_THAT(to_text(all, one.sections), HasSubstr("1 samples arrested at their largest load"));
  EXPECT_THAT(to_json(all, std::vector<std::string>{"a", "b"}, one.sections), HasSubstr("\"n_held\": 1,"));
}

TEST(Bases, MeansThatAgreeHaveTheErrorWithinBases) {
  constexpr int n = 16;
  const std::vector<input::Parameters> parameters{plate(1), plate(2), plate(3)};
  std::vector<SampleSummary> rows = rows_of(1, 1, n, 0.1);
  for (int i = 0; i < n; ++i) rows[static_cast<std::size_t>(i)].pattern = 1 + i % 2;
  std::vector<BaseSamples> bases;
  for (const input::Parameters& one : parameters) bases.push_back({&one, {}, rows, {}});
  const BasesStatistics all = statistics_of_bases(bases);
  const MeanOverBases& found = of(all, "pattern");
  EXPECT_EQ(found.mean.value, 0.5);
  // Of 16 values 1/4 * 16 / 15, over three bases; Student's t for two degrees of freedom.
  const double error = std::sqrt(0.25 * n / (n - 1) / (3 * n));
  EXPECT_NEAR(found.mean.lower, 0.5 - 4.302652729749462 * error, 1e-12);
  EXPECT_NEAR(found.mean.upper, 0.5 + 4.302652729749462 * error, 1e-12);
}

TEST(Bases, CountsHaveMeansAndShares) {
  const auto one = plate(1), other = plate(2);
  auto first = rows_of(1, 1, 4, 0.1), second = rows_of(1, 2, 4, 0.1);
  for (const std::size_t i : {0, 1, 2}) first[i].kinks = 4;
  second[0].kinks = 4;
  const BasesStatistics all =
      statistics_of_bases(std::vector<BaseSamples>{{&one, {}, first, {}}, {&other, {}, second, {}}});
  EXPECT_THAT(of(all, "kinks").of_base, ::testing::ElementsAre(3, 1));
  const std::string text = to_text(all, one.sections);
  EXPECT_THAT(text, ::testing::ContainsRegex("\nkinks +8 +2\\.00 "));
  EXPECT_THAT(text, ::testing::ContainsRegex("\nkinks: any \\[%\\] +8 +50\\.0 "));
}

TEST(Bases, GroupsOfPathsHaveNoMean) {
  const auto one = plate(1), other = plate(2);
  auto first = rows_of(1, 1, 10, 0.1), second = rows_of(1, 2, 10, 0.1);
  double place = 0.05;
  for (auto* const rows : {&first, &second}) {
    for (SampleSummary& row : *rows) row.position = {place += 1e-4};
    place += 0.02;
  }
  const BasesStatistics all =
      statistics_of_bases(std::vector<BaseSamples>{{&one, {}, first, {}}, {&other, {}, second, {}}});
  EXPECT_TRUE(of(all, "position").is_divided);
  EXPECT_THAT(to_text(all, one.sections),
              ::testing::ContainsRegex("leader, start 0, y = 10 mm \\[mm\\] +20 +groups +- +- "));
}

std::vector<std::string> settings_but_seed(input::Parameters parameters) {
  parameters.seed = 0;
  return input::sample_settings(parameters);
}

TEST(Bases, WhatAreNotSeveralBasesIsRefused) {
  const auto rows = rows_of(1, 1, 3, 0.1);
  const auto refused = [&](const input::Parameters& other, const char* reason) {
    const input::Parameters one = plate(1);
    const std::vector<BaseSamples> bases{{&one, settings_but_seed(one), rows, {}},
                                         {&other, settings_but_seed(other), rows, {}}};
    try {
      statistics_of_bases(bases);
      ADD_FAILURE() << reason;
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr(reason));
    }
  };
  refused(plate(1), "have the same seed, 1");
  auto other = plate(2);
  other.materials[0].density = 1000;
  refused(other, "differ in more than ensemble.seed");
  other = plate(2);
  other.mesh.base = input::Base::own;
  refused(other, "mesh.base is \"own\"");
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::analysis
