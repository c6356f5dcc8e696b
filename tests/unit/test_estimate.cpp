// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/estimate.h"

#include <gmock/gmock.h>

#include <cstdio>

namespace crackle::ensemble {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

input::Parameters paper_like() {
  input::Parameters parameters;
  parameters.ensemble.samples = 200;
  parameters.time.duration = 100e-6;
  parameters.time.step = 5e-9;
  return parameters;
}

TEST(Estimate, CountsStepsAndForceEvaluations) {
  auto parameters = paper_like();
  auto estimate = make_estimate(parameters, 310000, 40e-9);
  EXPECT_EQ(estimate.step, 5e-9);
  EXPECT_EQ(estimate.steps, 20000);
  // Eight kicks in two steps, of which the last shares its force with the first of the next two.
  EXPECT_EQ(estimate.force_evaluations, 70000);
  std::printf("core-hours %.4g\n", estimate.core_hours);
  EXPECT_NEAR(estimate.core_hours,
              200 * 70000.0 * 310000 / updates_per_core_second(input::Precision::mixed) / 3600, 1e-9);
  parameters.time.integrator = input::Integrator::verlet;
  estimate = make_estimate(parameters, 310000, 40e-9);
  EXPECT_EQ(estimate.force_evaluations, 20000);
}

TEST(Estimate, AutomaticStepStaysBelowTheStableOneAndDividesTheDuration) {
  auto parameters = paper_like();
  parameters.time.step.reset();
  const auto estimate = make_estimate(parameters, 5000, 40e-9);
  std::printf("step %.6g ns, %ld steps\n", estimate.step * 1e9, static_cast<long>(estimate.steps));
  EXPECT_LE(estimate.step, 0.9 * 40e-9);
  EXPECT_GT(estimate.step, 0.89 * 40e-9);
  EXPECT_DOUBLE_EQ(estimate.step * static_cast<double>(estimate.steps), 100e-6);
}

TEST(Estimate, RefusesAStepOverTheStableOne) {
  auto parameters = paper_like();
  parameters.time.step = 50e-9;
  try {
    make_estimate(parameters, 5000, 40e-9);
    FAIL() << "a step over the stable one was accepted";
  } catch (const std::runtime_error& error) {
    std::printf("%s\n", error.what());
    EXPECT_THAT(error.what(), AllOf(StartsWith("time.step: 50 ns"), HasSubstr("stable step"),
                                    HasSubstr("40 ns"), HasSubstr("\"auto\"")));
  }
  EXPECT_THROW(make_estimate(paper_like(), 5000, 0), std::runtime_error);
}

}  // namespace
}  // namespace crackle::ensemble
