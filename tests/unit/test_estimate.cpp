// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/estimate.h"

#include "crackle/dynamics/stable_step.h"

#include <gmock/gmock.h>

#include <cstdio>

namespace crackle::ensemble {
namespace {

input::Parameters paper_like() {
  input::Parameters parameters;
  parameters.ensemble.samples = 200;
  parameters.time.duration = 100e-6;
  parameters.time.step = 5e-9;
  return parameters;
}

TEST(Estimate, StepsCoverTheDurationWithoutRoundingOneUp) {
  EXPECT_EQ(n_steps(100e-6, 5e-9), 20000);
  EXPECT_EQ(n_steps(0.3, 0.1), 3);
  EXPECT_EQ(n_steps(1.0, 0.3), 4);
  EXPECT_EQ(n_steps(1e-9, 1e-9), 1);
}

TEST(Estimate, CountsStepsAndForceEvaluations) {
  auto parameters = paper_like();
  auto estimate = make_estimate(parameters, 55000, 310000, 40e-9);
  EXPECT_EQ(estimate.step, 5e-9);
  EXPECT_EQ(estimate.steps, 20000);
  EXPECT_EQ(estimate.force_evaluations, 80000);
  std::printf("core-hours %.4g, memory %.4g MB\n", estimate.core_hours, estimate.sample_memory / 1e6);
  EXPECT_NEAR(estimate.core_hours, 200 * 80000.0 * 310000 / updates_per_core_second / 3600, 1e-9);
  EXPECT_GT(estimate.sample_memory, 310000 * 100.0);
  parameters.time.integrator = input::Integrator::verlet;
  estimate = make_estimate(parameters, 55000, 310000, 40e-9);
  EXPECT_EQ(estimate.force_evaluations, 20000);
}

TEST(Estimate, AutomaticStepIsAPartOfTheStableOne) {
  auto parameters = paper_like();
  parameters.time.step.reset();
  const auto estimate = make_estimate(parameters, 1000, 5000, 40e-9);
  EXPECT_DOUBLE_EQ(estimate.step, dynamics::automatic_step_fraction * 40e-9);
}

TEST(Estimate, RefusesAStepOverTheStableOne) {
  auto parameters = paper_like();
  parameters.time.step = 50e-9;
  try {
    make_estimate(parameters, 1000, 5000, 40e-9);
    FAIL() << "a step over the stable one was accepted";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(
        error.what(),
        "time.step: 50 ns is over the stable step 40 ns of this mesh and integrator; give a smaller one "
        "or \"auto\"");
  }
  EXPECT_THROW(make_estimate(paper_like(), 1000, 5000, 0), std::runtime_error);
}

}  // namespace
}  // namespace crackle::ensemble
