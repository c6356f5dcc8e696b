// SPDX-License-Identifier: GPL-3.0-or-later
// Outcomes of samples, their first break and their onset.
#include "common/index.h"
#include "dynamics/parting_watch.h"
#include "dynamics/sample_run.h"
#include "dynamics/separation.h"
#include "fracture/connectivity.h"
#include "parallel/agreement.h"

#include "support/box_mesh.h"
#include "support/elastic_motion.h"
#include "support/job.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;
using ::testing::HasSubstr;

constexpr std::array<bool, 3> all{true, true, true};
constexpr std::array<bool, 3> along{false, false, true};

/// A bar of 2 x 4 x 12 mm, with conditions on its ends.
class Bar : public testing::Test {
protected:
  Bar() { parameters.output.frames = 3; }

  void add(Face face, BoundaryKind kind, std::array<bool, 3> components, double value, double rate = 0) {
    parameters.boundaries.push_back(test::boundary(face, kind, components, {0, 0, value}, {0, 0, rate}));
  }
  void hold_below() { add(Face::z_min, BoundaryKind::fix, all, 0); }

  SampleResult run() {
    return run(test::make_box({.size = parameters.specimen.size, .cells = {2, 4, 12}, .disturbance = 0.2}));
  }
  SampleResult run(const geometry::Realization& mesh) {
    const auto subdomain = test::whole(mesh);
    const parallel::Communicator self(MPI_COMM_SELF);
    log.clear();
    SampleControl control;
    control.log = [&](const std::string& line) { log.push_back(line); };
    control.failed = [&](SampleResult result) { partial = std::move(result); };
    const SampleResult result = run_sample(self, parameters, parameters.output, subdomain, control);
    std::printf("  %s, first break %.6g N at %.6g s, onset %.6g N, %zu breaks, %lld phases, %lld steps\n",
                to_string(result.outcome).c_str(), result.first_break_load, result.first_break_time,
                result.onset_force, result.breaks.size(),
                static_cast<long long>(result.counts.dynamic_phases),
                static_cast<long long>(result.counts.steps));
    return result;
  }

  std::string failure() {
    try {
      run();
    } catch (const std::exception& error) {
      return error.what();
    }
    return "no failure";
  }

  input::Parameters parameters = test::brittle({0.002, 0.004, 0.012});
  std::vector<std::string> log;
  std::optional<SampleResult> partial;
};

TEST_F(Bar, PulledByVelocitiesAtBothEndsComesApart) {
  parameters.time.start = input::Start::rest;
  add(Face::z_min, BoundaryKind::velocity, all, -20);
  add(Face::z_max, BoundaryKind::velocity, all, 20);
  const auto result = run();
  EXPECT_EQ(result.outcome, Outcome::separated);
  EXPECT_TRUE(std::isnan(result.onset_force)) << "nothing was loaded quasi-statically";
  EXPECT_TRUE(std::isnan(result.onset_time));
  EXPECT_EQ(result.phase_start, 0);
  EXPECT_GT(result.first_break_time, 0);
  EXPECT_LT(result.first_break_time, 4e-5);
  // At the clamped ends, once the stress wave arrives: E v / c reaches the strength.
  EXPECT_GT(result.first_break_load, 0.2 * 35e6 * 0.002 * 0.004);
  EXPECT_LT(result.first_break_load, 2 * 35e6 * 0.002 * 0.004);
  EXPECT_THAT(log, testing::Not(testing::Contains(HasSubstr("instability"))));
}

TEST_F(Bar, PulledByTractionsAtBothEndsComesApart) {
  parameters.time.start = input::Start::rest;
  add(Face::z_min, BoundaryKind::traction, {}, -40e6);
  add(Face::z_max, BoundaryKind::traction, {}, 40e6);
  EXPECT_EQ(run().outcome, Outcome::separated);
}

TEST_F(Bar, PulledQuasiStaticallyByMovingBothEndsComesApart) {
  add(Face::z_min, BoundaryKind::velocity, all, -1e-6);
  add(Face::z_max, BoundaryKind::velocity, all, 1e-6);
  const auto result = run();
  EXPECT_EQ(result.outcome, Outcome::separated);
  EXPECT_NEAR(result.onset_force, result.first_break_load, 2e-3 * result.onset_force);
}

TEST_F(Bar, AtRestThatDoesNotBreakIsUnbroken) {
  parameters.time.start = input::Start::rest;
  hold_below();
  add(Face::z_max, BoundaryKind::traction, {}, 1e6);
  const auto result = run();
  EXPECT_EQ(result.outcome, Outcome::unbroken);
  EXPECT_TRUE(std::isnan(result.first_break_time));
  EXPECT_TRUE(std::isnan(result.first_break_load));
}

TEST_F(Bar, UnderAForceTooSmallForMixedNumbersIsComputedInDouble) {
  parameters.time.start = input::Start::rest;
  hold_below();
  add(Face::z_max, BoundaryKind::traction, {}, 1e2);
  const auto result = run();
  EXPECT_EQ(result.outcome, Outcome::unbroken);
  EXPECT_EQ(result.counts.range_restarts, 1);
  EXPECT_LT(result.energy_error, 1e-4);
  EXPECT_THAT(log, testing::Contains(HasSubstr("are too small for the mixed number format")));
}

/// The tension is density times speed times velocity, so that the strength is reached at 2 m/s. A step
/// overshoots, which bulk viscosity lessens. What stays on the wall is less than a hundredth, in many pieces.
TEST_F(Bar, FliesOffAWallAndIsSeparated) {
  parameters.materials[0] = {.youngs_modulus = 10e9, .poisson_ratio = 0, .density = 2500};
  parameters.fracture.strength = 10e6;
  parameters.specimen.size = {0.002, 0.002, 0.03};
  parameters.time.start = input::Start::rest;
  hold_below();
  const auto mesh = test::irregular_box(parameters.specimen.size, 0.6e-3);
  const auto at_speed = [&](double speed, const input::BulkViscosity& bulk) {
    parameters.loads = {{.kind = input::LoadKind::velocity, .value = {0, 0, speed}}};
    parameters.damping = {.mass = 0, .bulk = bulk};
    return run(mesh);
  };
  EXPECT_EQ(at_speed(1.7, {}).outcome, Outcome::separated) << "the overshoot is 15 % or more";
  EXPECT_NE(at_speed(1.6, {0.06, 1.2}).outcome, Outcome::separated) << "single tetrahedra may break";
  EXPECT_EQ(at_speed(1.7, {0.5, 1.2}).outcome, Outcome::unbroken);
  for (const input::BulkViscosity bulk : {input::BulkViscosity{}, input::BulkViscosity{0.5, 1.2}}) {
    const auto result = at_speed(2.2, bulk);
    EXPECT_EQ(result.outcome, Outcome::separated);
    EXPECT_GT(result.separated_at, 0);
    EXPECT_LT(result.separated_at, 5e-6);
    EXPECT_LT(result.energy_error, 1e-4);
  }
}

TEST_F(Bar, InOnePieceWhenTheDurationIsOver) {
  parameters.time.start = input::Start::rest;
  parameters.time.duration = 1e-5;
  hold_below();
  add(Face::z_max, BoundaryKind::velocity, along, 7);
  const auto result = run();
  ASSERT_FALSE(result.breaks.empty());
  EXPECT_EQ(result.outcome, Outcome::running);
}

TEST_F(Bar, OverloadedAtTimeZeroIsRefusedWithTheFirstBreak) {
  hold_below();
  add(Face::z_max, BoundaryKind::force, {}, 0, 10);
  const double first_break = run().first_break_load;
  parameters.boundaries.back().value = {0, 0, 400};
  EXPECT_THAT(failure(),
              testing::AllOf(HasSubstr("the load at time 0, 400 N, exceeds that of the first break"),
                             HasSubstr(fmt::format("first break, {:.6g} N", first_break)),
                             HasSubstr("start = \"equilibrium\"")));
  ASSERT_TRUE(partial.has_value());
  EXPECT_TRUE(partial->breaks.empty());
}

TEST_F(Bar, StartsFromAnOverloadedEquilibrium) {
  hold_below();
  add(Face::z_max, BoundaryKind::force, {}, 400);
  parameters.time.start = input::Start::equilibrium;
  const auto result = run();
  EXPECT_EQ(result.outcome, Outcome::separated);
  EXPECT_NEAR(result.onset_force, 400, 1e-9);
  EXPECT_EQ(result.onset_time, 0);
  EXPECT_NEAR(result.first_break_load, 400, 1e-9);
  EXPECT_LT(result.first_break_time, 5e-6);
  // Many places exceed the strength, and all of them break at once.
  EXPECT_GT(result.breaks.size(), 50U);
  EXPECT_LT(result.energy_error, 1e-3);
}

TEST_F(Bar, AnUnloadedEquilibriumThatNothingLoadsIsUnbroken) {
  hold_below();
  add(Face::z_max, BoundaryKind::force, {}, 1);
  parameters.time.start = input::Start::equilibrium;
  for (const double window : {5e-6, 4 * parameters.time.duration}) {  // also longer than the longest phase
    parameters.time.arrest = window;
    const auto result = run();
    EXPECT_EQ(result.outcome, Outcome::unbroken) << window;
    EXPECT_EQ(result.note, "") << window;
    EXPECT_TRUE(std::isnan(result.first_break_load));
  }
}

/// A wave that takes longer to arrive than the window, and the arrest after its breaks.
TEST_F(Bar, InMotionFromAnEquilibriumArrestsOnlyAfterABreak) {
  hold_below();
  add(Face::z_max, BoundaryKind::traction, {}, 34e6);
  parameters.boundaries.back().history = {{0, 0.1}, {20e-6, 0.1}, {21e-6, 1}, {22e-6, 0.1}};
  parameters.time.start = input::Start::equilibrium;
  parameters.time.arrest = 6e-6;
  parameters.time.duration = 100e-6;
  const auto result = run();
  EXPECT_GT(result.first_break_time, 20e-6);
  EXPECT_LT(result.first_break_time, 34e-6);
  EXPECT_EQ(result.outcome, Outcome::arrested);
  EXPECT_THAT(result.note, HasSubstr("before time.duration, 100 us: nothing had broken for 6 us"));
  // Without a break the motion lasts for the whole duration.
  parameters.boundaries.back().value[2] = 3e6;
  const auto unbroken = run();
  EXPECT_EQ(unbroken.outcome, Outcome::unbroken);
  EXPECT_EQ(unbroken.note, "");
  EXPECT_GT(unbroken.energy.back().time, 0.999 * parameters.time.duration);
}

TEST_F(Bar, FirstBreakAndOnsetDifferWhereABreakIsNoRunAway) {
  hold_below();
  add(Face::z_max, BoundaryKind::force, {}, 0, 10);
  parameters.time.arrest = 1e-30;  // every break is quasi-static, until the bar is in two pieces
  const auto result = run();
  EXPECT_EQ(result.outcome, Outcome::separated);
  EXPECT_TRUE(std::isnan(result.onset_force));
  EXPECT_EQ(result.first_break_time, result.breaks.front().load_time);
  EXPECT_NEAR(result.first_break_load, 10 * result.first_break_time, 1e-9 * result.first_break_load);
  EXPECT_GT(result.equilibrium_residual, 0);
  EXPECT_LT(result.equilibrium_residual, 3e-8);
}

/// A strip with a slot, wedged open: cracks arrest again and again.
class WedgedStrip : public Bar {
protected:
  WedgedStrip() {
    parameters.specimen.size = {0.001, 0.012, 0.03};
    for (const auto& [face, sign] : {std::pair{Face::y_max, 1.0}, {Face::y_min, -1.0}}) {
      auto wedge = test::boundary(face, BoundaryKind::displacement, all, {0, sign * 1e-5, 0});
      wedge.region[2] = {0, 0.0021};
      wedge.history = {{0, 0}, {100, 100}};
      parameters.boundaries.push_back(wedge);
    }
    parameters.time.arrest = 1e-5;
  }
  SampleResult run() {
    const auto mesh = test::make_box({.size = parameters.specimen.size,
                                      .cells = {1, 12, 30},
                                      .disturbance = 0.15,
                                      .removed = [](const geometry::Point& p) {
                                        return p[2] < 0.4 * 0.03 && std::abs(p[1] - 0.0065) < 0.0005;
                                      }});
    const parallel::Communicator self(MPI_COMM_SELF);
    const SampleResult result = run_sample(self, parameters, parameters.output, test::whole(mesh));
    std::printf("  %s, first break %.6g s, onset %.6g s, %zu breaks, %lld phases, %zu rows up to %.3g us\n",
                to_string(result.outcome).c_str(), result.first_break_time, result.onset_time,
                result.breaks.size(), static_cast<long long>(result.counts.dynamic_phases),
                result.energy.size(), result.energy.empty() ? 0.0 : 1e6 * result.energy.back().time);
    return result;
  }
};

TEST_F(WedgedStrip, AShortDurationDoesNotMakeAnArrestedPhaseTheLast) {
  // A break 2 us before the end of the phase: whether it has arrested is only known later.
  parameters.time.duration = 6e-5;
  const auto full = run();
  ASSERT_GE(full.counts.dynamic_phases, 3);
  parameters.time.duration = 1.2e-5;
  const auto brief = run();
  EXPECT_GE(brief.counts.dynamic_phases, 3);
  EXPECT_EQ(brief.first_break_time, full.first_break_time);
}

TEST_F(WedgedStrip, WhatHasNotArrestedWithinThreeDurationsIsUndecided) {
  parameters.time.duration = 6e-6;
  parameters.time.arrest = 4e-5;  // longer than three durations
  const auto result = run();
  EXPECT_EQ(result.outcome, Outcome::undecided);
  EXPECT_THAT(result.note, HasSubstr("cracks were still running at time.duration = 6 us"));
  ASSERT_FALSE(result.breaks.empty());
  // Outputs are limited to the duration.
  for (const auto& one : result.breaks) EXPECT_LE(one.phase_time, 6e-6 * (1 + 1e-12));
  EXPECT_NEAR(result.energy.back().time, 6e-6, 1e-12);
  EXPECT_EQ(result.energy.back().broken, static_cast<std::int64_t>(result.breaks.size()));
  EXPECT_EQ(result.frames.size(), 3U);
  EXPECT_GT(static_cast<double>(result.counts.steps) * result.time_step, 17e-6);
}

TEST_F(Bar, PhaseEndsAfterSeparationOnlyWhenAsked) {
  hold_below();
  add(Face::z_max, BoundaryKind::force, {}, 0, 10);
  parameters.time.precision = input::Precision::double_;
  parameters.time.duration = 1e-4;
  const auto whole = run();
  ASSERT_EQ(whole.outcome, Outcome::separated);
  parameters.time.after_separation = 1e-5;
  const auto ended = run();
  EXPECT_EQ(ended.outcome, Outcome::separated);
  EXPECT_EQ(ended.onset_force, whole.onset_force);
  EXPECT_LT(ended.energy.back().time, 0.8 * whole.energy.back().time);
  EXPECT_GT(ended.energy.back().time, 1e-5);
  // Up to its end it is the same.
  ASSERT_LE(ended.breaks.size(), whole.breaks.size());
  for (std::size_t i = 0; i < ended.breaks.size(); ++i)
    EXPECT_EQ(ended.breaks[i].tetrahedron, whole.breaks[i].tetrahedron);
  EXPECT_EQ(ended.energy[5].strain, whole.energy[5].strain);
}

TEST_F(Bar, DustFliesAnyDistanceInDoubleAndTheSampleGoesOn) {
  parameters.time.start = input::Start::rest;
  parameters.time.integrator = input::Integrator::verlet;
  hold_below();
  add(Face::z_max, BoundaryKind::force, {}, 600);
  parameters.time.duration = 5e-3;  // for the dead load to carry its piece away
  parameters.output.frames = 200;
  const auto result = run();
  EXPECT_EQ(result.outcome, Outcome::separated);
  EXPECT_EQ(result.counts.range_restarts, 1) << "first it is tried in double";
  EXPECT_EQ(result.note, "");
  EXPECT_NEAR(result.energy.back().time, parameters.time.duration, 1e-6);
  EXPECT_GT(result.fragment_history.back().dust, 0);
  EXPECT_EQ(result.fragment_history.back().frozen, 0);
  EXPECT_LT(result.energy_error, 1e-3);
}

TEST(Separation, CountsPiecesByTheirVolume) {
  input::Parameters parameters;
  parameters.materials[0] = test::epoxy();
  parameters.specimen.size = {0.002, 0.004, 0.012};
  parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::traction, {}, {0, 0, -1}));
  const auto mesh =
      test::make_box({.size = parameters.specimen.size, .cells = {2, 4, 12}, .disturbance = 0.2});
  const auto subdomain = test::whole(mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
  const auto cut_at = [&](double z) {
    fracture::BreakableBody body(subdomain, parameters.material());
    for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t) {
      double low = 1, high = 0;
      for (const auto node : subdomain.tetrahedra[index(t)]) {
        low = std::min(low, subdomain.nodes[index(node)][2]);
        high = std::max(high, subdomain.nodes[index(node)][2]);
      }
      if (low < z && high > z) body.release(t, {1e-3, 0, 0, 0, 0, 0}, 0, 0);
    }
    return is_separated(self, body, loads);
  };
  EXPECT_FALSE(cut_at(-1)) << "nothing is cut";
  EXPECT_TRUE(cut_at(0.0062)) << "only one end is loaded, but half of the body came off";
}

TEST(Separation, IsSoughtOnlyAfterBreaksThatMayHavePartedTheBody) {
  input::Parameters parameters;
  parameters.materials[0] = test::epoxy();
  parameters.specimen.size = {0.006, 0.006, 0.012};
  for (const Face face : {Face::z_min, Face::z_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::traction, {}, {0, 0, 1}));
  const auto mesh =
      test::make_box({.size = parameters.specimen.size, .cells = {9, 9, 18}, .disturbance = 0.2});
  const auto subdomain = test::whole(mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
  struct Break {
    double order;
    std::int32_t tetrahedron;
  };
  std::vector<Break> as_crack, scattered;
  for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t) {
    double low = 1, high = 0, x = 0;
    for (const auto node : subdomain.tetrahedra[index(t)]) {
      low = std::min(low, subdomain.nodes[index(node)][2]);
      high = std::max(high, subdomain.nodes[index(node)][2]);
      x += subdomain.nodes[index(node)][0] / 4;
    }
    if (low < 0.0062 && high > 0.0062) as_crack.push_back({x, t});
    if (low > 0.004 && high < 0.008) scattered.push_back({std::fmod(0.618034 * t, 1), t});
  }
  for (auto* const breaks : {&as_crack, &scattered}) {
    std::ranges::sort(*breaks, {}, &Break::order);
    for (const std::size_t per_look : {1, 2, 5, 20}) {
      fracture::BreakableBody body(subdomain, parameters.material());
      PartingWatch watch(self, body, loads);
      EXPECT_TRUE(watch.may_have_parted()) << "nothing is known before";
      bool is_apart = false;
      double n = 0, n_certain = 0;
      for (std::size_t i = 0; i < breaks->size() && !is_apart; ++i) {
        const std::int32_t t = (*breaks)[i].tetrahedron;
        body.release(t, {1e-3, 0, 0, 0, 0, 0}, 0, 0);
        watch.note(std::array{t});
        if ((i + 1) % per_look != 0) continue;
        const bool may_have_parted = watch.may_have_parted();
        const auto labels = fracture::piece_labels(self, body);
        is_apart = is_separated(self, body, loads, labels) || is_unloaded(self, body, loads, labels);
        EXPECT_TRUE(may_have_parted || !is_apart) << per_look;
        ++n;
        n_certain += may_have_parted ? 0 : 1;
      }
      EXPECT_TRUE(is_apart);
      if (per_look > 1) continue;
      RecordProperty(breaks == &as_crack ? "crack" : "scattered", std::to_string(n_certain / n));
      EXPECT_GT(n_certain, 0.8 * n) << n;
    }
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
