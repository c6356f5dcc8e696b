// SPDX-License-Identifier: GPL-3.0-or-later
// The results of a sweep's cases side by side.
#include "analysis/grouped_values.h"
#include "ensemble/sweep_table.h"

#include <gmock/gmock.h>

#include <sstream>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

using ::testing::HasSubstr;
using ::testing::Not;

std::vector<analysis::SampleSummary> rows_of(const std::vector<double>& displacements) {
  std::vector<analysis::SampleSummary> rows;
  for (const double one : displacements) {
    rows.push_back(analysis::empty_summary(1, 1, analysis::SampleStatus::done));
    rows.back().outcome = static_cast<std::int32_t>(dynamics::Outcome::separated);
    rows.back().displacement_at_peak = rows.back().peak_load = one;
    rows.back().kinks = one < 2 ? 1 : 0;
  }
  return rows;
}

/// A column of the table's first case.
double value_in(const std::string& csv, const std::string& column) {
  std::istringstream lines(csv);
  std::string head, row, name, value;
  std::getline(lines, head);
  std::getline(lines, row);
  std::istringstream heads(head), values(row);
  while (std::getline(heads, name, ',') && std::getline(values, value, ','))
    if (name == '"' + column + '"') return std::stod(value);
  throw std::out_of_range(column);
}

TEST(SweepTable, ReplicatesCountByWholeDraws) {
  input::Case one{{}, {}};
  one.parameters.ensemble.replicates = 3;
  const CaseRows rows{&one, "case-0", rows_of({1, 1.1, 0.9, 3, 3.1, 2.9})};
  const std::string csv = sweep_csv(std::span(&rows, 1));
  // As of two values, 1 and 3.
  EXPECT_NEAR(value_in(csv, "displacement_at_peak [m]"), 2, 1e-9);
  EXPECT_NEAR(value_in(csv, "displacement_at_peak [m] upper"), 2 + 12.7062047364, 1e-8);
  const auto share = analysis::share_interval(1, 2, analysis::default_confidence);
  EXPECT_NEAR(value_in(csv, "kinks: any"), 0.5, 1e-9);
  EXPECT_NEAR(value_in(csv, "kinks: any lower"), share.lower, 1e-9);
  one.parameters.ensemble.replicates = 1;
  EXPECT_LT(value_in(sweep_csv(std::span(&rows, 1)), "displacement_at_peak [m] upper"), 3.2);
}

TEST(SweepTable, TheFootnoteIsThatOfMeansOfBrokenSamples) {
  const input::Case one{{{"boundary[0].on", "\"*\""}}, {}};
  CaseRows rows{&one, "case-0", rows_of({1, 2})};
  EXPECT_THAT(sweep_text(std::span(&rows, 1)), Not(HasSubstr("*: of the samples that broke")));
  rows.rows[1].outcome = static_cast<std::int32_t>(dynamics::Outcome::unbroken);
  EXPECT_THAT(sweep_text(std::span(&rows, 1)), HasSubstr("*: of the samples that broke"));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
