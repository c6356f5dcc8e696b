// SPDX-License-Identifier: GPL-3.0-or-later
// The share of samples beyond a limit, and what it leaves out.
#include "crackle/analysis/exceedance.h"

#include <gmock/gmock.h>

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
  const Exceedance of_draws = exceedance("peak_load > 0.5 kN", parameters, alike);
  EXPECT_EQ(of_draws.n_hits, 16);
  EXPECT_EQ(of_draws.n_values, 64);
  const auto expected = wilson_interval(0.25, 32, 0.95);
  EXPECT_NEAR(of_draws.interval.lower, expected.centre - expected.half_width, 1e-12);
  EXPECT_NEAR(of_draws.interval.upper, expected.centre + expected.half_width, 1e-12);
  EXPECT_EQ(exceedance("peak_load<500 N", parameters, alike).n_hits, 48);
  EXPECT_EQ(to_text(of_draws).substr(0, 45), "peak_load > 500 N: 16 of 64 samples, 25.0 % (");
  EXPECT_EQ(to_text(of_draws).find("planned"), std::string::npos) << "nothing is left out";
  for (const char* const wrong :
       {"peak_load 500 N", "peak > 500 N", "peak_load > 500", "peak_load > 5 mm", ""})
    EXPECT_THROW(exceedance(wrong, parameters, alike), std::runtime_error) << wrong;
}

TEST(Exceedance, SaysWhatTheShareLeavesOut) {
  std::vector<SampleSummary> rows(24, done(600));
  rows[3].outcome = 4;
  rows.insert(rows.end(), 8, empty_summary(1, 1, SampleStatus::failed));
  rows.insert(rows.end(), 30, empty_summary(1, 1, SampleStatus::pending));
  rows.insert(rows.end(), 2, done(not_a_number));
  const Exceedance found = exceedance("peak_load > 500 N", ensemble(64), rows);
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

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::analysis
