// SPDX-License-Identifier: GPL-3.0-or-later
// A sample that is suspended and continued repeatedly, on changing numbers of ranks, ends bitwise equal to an
// undisturbed one.
#include "common/index.h"
#include "dynamics/checkpoint.h"
#include "dynamics/sample_run.h"
#include "parallel/collectives.h"

#include "support/box_mesh.h"
#include "support/effort.h"
#include "support/group.h"
#include "support/same_result.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

input::Parameters torn_bar() {
  auto parameters = test::torn_bar(2e-8);
  parameters.output.history = 1.3e-7;
  parameters.output.probes = {{"middle", {1e-3, 2.1e-3, 6.2e-3}}};
  return parameters;
}

/// Leaves the range of mixed precision, as its halves are pulled apart: the faster, the sooner.
input::Parameters torn_bar_for_longer() {
  auto parameters = torn_bar();
  parameters.time.step = 8e-8;
  parameters.time.duration = 2e-4;
  parameters.boundaries.back().rate = {0, 0, 2e11};
  return parameters;
}

/// As pulled_bar, but after a phase has arrested the load grows within a step to 500 times the strength of
/// the body: the next phase leaves the range of mixed precision.
input::Parameters jerked_bar() {
  auto parameters = test::pulled_bar(torn_bar());
  auto& load = parameters.boundaries.back();
  load.rate = {};
  load.value = {0, 0, 1};
  load.history = {{0, 0}, {19, 190}, {19 + 1e-8, 1e5}};
  return parameters;
}

class Checkpoints : public testing::Test {
protected:
  geometry::Subdomain part(const parallel::Communicator& group) const {
    return geometry::split(mesh_, geometry::partition(mesh_, group.size()), halo_)[index(group.rank())];
  }

  /// The sample in pieces, each suspended after a number of polls. Complete on rank 0.
  /// @param on_fewer every second piece is computed on rank 0 alone
  SampleResult in_pieces(const input::Parameters& parameters, bool on_fewer) {
    std::vector<std::byte> saved;
    SampleResult result;
    n_suspended_ = n_saved_ = n_again_in_double_ = n_on_in_double_ = 0;
    bool is_suspended = true;
    for (int piece = 0; is_suspended; ++piece) {
      const parallel::Communicator& group = on_fewer && piece % 2 == 1 ? self_ : world_;
      int n_looks = 0;
      SampleControl control;
      // The last rank of the group requests it: the others must follow.
      control.stop = [&] { return group.rank() == group.size() - 1 && ++n_looks > piece + 2; };
      control.save = [&](std::span<const std::byte> bytes) {
        saved.assign(bytes.begin(), bytes.end());
        ++n_saved_;
      };
      control.log = [&](const std::string& line) {
        n_again_in_double_ += line.find("is computed again with time.precision") != line.npos ? 1 : 0;
        n_on_in_double_ += line.find("continues with time.precision") != line.npos ? 1 : 0;
      };
      if (group.is_root()) control.checkpoint = saved;
      if (group.size() == world_.size() || world_.is_root())
        result = run_sample(group, parameters, parameters.output, part(group), control);
      is_suspended = result.suspended;
      MPI_Bcast(&is_suspended, 1, MPI_CXX_BOOL, 0, world_.get());
      n_suspended_ += is_suspended ? 1 : 0;
    }
    return result;
  }

  void compare(const char* name, const input::Parameters& parameters, bool on_fewer,
               int n_range_restarts = 0) {
    const auto pieces = in_pieces(parameters, on_fewer);
    if (!world_.is_root()) return;
    const auto& whole =
        test::reference([&] { return run_sample(self_, parameters, parameters.output, part(self_)); });
    std::printf("%s%s: %zu breaks, %ld dynamic phases, %ld steps, suspended %d times with %d checkpoints\n",
                name, on_fewer ? " with changing ranks" : "", whole.breaks.size(),
                static_cast<long>(whole.counts.dynamic_phases), static_cast<long>(whole.counts.steps),
                n_suspended_, n_saved_);
    EXPECT_GT(whole.breaks.size(), 20U) << "the case must break";
    EXPECT_GE(n_saved_, 2);
    test::expect_same_course(whole, pieces);
    EXPECT_EQ(whole.counts.range_restarts, n_range_restarts);
    if (n_range_restarts == 0) return;
    std::printf(
        "  left the range of mixed numbers: %d times from the start in double, %d times on in double\n",
        n_again_in_double_, n_on_in_double_);
    EXPECT_GE(n_on_in_double_, 1);
  }

  /// The checkpoint saved when the sample is asked to park at its `n`th poll. On the root.
  std::vector<std::byte> suspended_at_poll(int n, const input::Parameters& parameters) const {
    std::vector<std::byte> saved;
    int n_looks = 0;
    SampleControl control;
    control.stop = [&] { return ++n_looks >= n; };
    control.save = [&](std::span<const std::byte> bytes) { saved.assign(bytes.begin(), bytes.end()); };
    EXPECT_TRUE(run_sample(world_, parameters, parameters.output, part(world_), control).suspended);
    return saved;
  }

  parallel::Communicator world_{test::group()}, self_{MPI_COMM_SELF};
  double halo_ = 0;
  geometry::Realization mesh_ =
      test::make_box({.size = torn_bar().specimen.size, .cells = {3, 5, 14}, .disturbance = 0.2});
  int n_suspended_ = 0, n_saved_ = 0;
  int n_again_in_double_ = 0, n_on_in_double_ = 0;
};

TEST_F(Checkpoints, ContinueToTheSameBits) {
  for (const auto integrator : {input::Integrator::bilateral4, input::Integrator::verlet}) {
    auto parameters = torn_bar();
    parameters.time.integrator = integrator;
    const char* name = integrator == input::Integrator::verlet ? "verlet" : "bilateral4";
    compare(name, parameters, false);
    compare(name, parameters, true);
  }
}

TEST_F(Checkpoints, KeepWhatDampersRemember) {
  for (const bool is_mixed : {true, false}) {
    for (auto parameters : {torn_bar(), test::pulled_bar(torn_bar())}) {
      parameters.time.integrator = input::Integrator::verlet;
      parameters.time.precision = is_mixed ? input::Precision::mixed : input::Precision::double_;
      parameters.damping = {.mass = 1e4, .bulk = {0.06, 1.2}};
      parameters.boundaries.push_back(test::boundary(Face::y_max, BoundaryKind::absorbing));
      compare(is_mixed ? "dampers, mixed" : "dampers, double", parameters, true);
    }
  }
}

TEST_F(Checkpoints, ContinueWithTheSameAddedMasses) {
  for (auto parameters : {torn_bar(), test::pulled_bar(torn_bar())}) {
    parameters.time.mass_scaling = 0.005;
    compare("added masses", parameters, true);
  }
}

TEST_F(Checkpoints, KeepWhatFacetsAndTiesReleased) {
  auto parameters = torn_bar();
  parameters.fracture.release = input::Release::facet;
  compare("facets", parameters, true);
  parameters.fracture.contact = input::Contact::frictionless;
  compare("facets with contact", parameters, true);
  parameters = test::pulled_bar(torn_bar());
  parameters.fracture.release = input::Release::facet;
  compare("facets, quasi-static", parameters, true);
}

TEST_F(Checkpoints, KeepWhatStickAndSlip) {
  for (const auto release : {input::Release::element, input::Release::facet}) {
    auto parameters = torn_bar();
    parameters.fracture.release = release;
    parameters.contact = input::SurfaceContact{.friction = 0.3};
    parameters.boundaries = {
        test::boundary(plane::Face::z_min, input::BoundaryKind::fix, {true, true, true}),
        test::boundary(plane::Face::z_max, input::BoundaryKind::velocity, {true, true, true}, {5, 0, -60})};
    compare("rubble", parameters, true);
    parameters.time.integrator = input::Integrator::verlet;
    if (release == input::Release::element || test::is_full()) compare("rubble, verlet", parameters, true);
    // Two bars that meet.
    const auto in_one =
        std::exchange(mesh_, test::make_box({.size = parameters.specimen.size,
                                             .cells = {3, 5, 45},
                                             .disturbance = 0.2,
                                             .removed = [](const geometry::Point& p) {
                                               return std::abs(p[2] - torn_bar().specimen.size[2] / 2) < 1e-4;
                                             }}));
    parameters.boundaries.back().value = {0, 0, -12};
    parameters.time.duration = 3e-5;
    compare("two bars", parameters, true);
    mesh_ = in_one;
  }
  auto parameters = test::pulled_bar(torn_bar());
  parameters.contact = input::SurfaceContact{.friction = 0.3};
  compare("contact, quasi-static", parameters, true);
}

TEST_F(Checkpoints, KeepTheTeethThatFell) {
  auto parameters = torn_bar();
  parameters.fracture.release = input::Release::softening;
  parameters.fracture.toughness = 900;
  compare("softening", parameters, true);
  parameters = test::pulled_bar(torn_bar());
  parameters.time.duration = 3e-5;
  parameters.fracture.release = input::Release::softening;
  parameters.fracture.toughness = 300;
  compare("softening, quasi-static", parameters, true);
}

TEST_F(Checkpoints, KeepReleasesUnderWay) {
  for (const auto release : {input::Release::element, input::Release::facet, input::Release::softening}) {
    auto parameters = torn_bar();
    parameters.fracture.release = release;
    parameters.fracture.release_time = 2e-6;  // some 100 steps, three polls
    if (release == input::Release::softening) parameters.fracture.toughness = 900;
    compare("release in time", parameters, true);
  }
  auto parameters = torn_bar();
  parameters.fracture.release_time = 2e-6;
  parameters.fracture.contact = input::Contact::frictionless;
  compare("release in time with contact", parameters, true);
  parameters = torn_bar();
  parameters.fracture.release_speed = 400;  // over some 2 us
  compare("release by a speed", parameters, true);
  parameters = test::pulled_bar(torn_bar());
  parameters.fracture.release_time = 1e-6;
  compare("release in time, quasi-static", parameters, true);
}

TEST_F(Checkpoints, KeepTheStrengthsNearCracks) {
  for (auto parameters : {torn_bar(), test::pulled_bar(torn_bar())}) {
    parameters.fracture.toughness = 50;
    parameters.time.step = 1e-8;
    parameters.fracture.strength = 45e6;  // more than at cracks
    compare("strength and toughness", parameters, true);
    if (parameters.time.start != input::Start::rest && !test::is_full()) continue;
    parameters.fracture.strength = 12e6;  // less
    compare("strength and toughness", parameters, true);
    parameters.fracture.strength = 45e6;
    parameters.fracture.nucleation = input::Nucleation::own_stress;
    compare("strength and toughness, own stress", parameters, true);
  }
}

TEST_F(Checkpoints, KeepWhatBallsBroke) {
  auto parameters = torn_bar();
  parameters.fracture.length = halo_ = 1.5e-3;
  compare("averaged stress", parameters, true);
}

TEST_F(Checkpoints, KeepArrestedPhases) {
  compare("quasi-static", test::pulled_bar(torn_bar()), false);
  compare("quasi-static", test::pulled_bar(torn_bar()), true);
  auto parameters = test::pulled_bar(torn_bar());
  parameters.time.precision = input::Precision::double_;
  compare("quasi-static, double", parameters, true);
}

TEST_F(Checkpoints, KeepThatMixedNumbersDidNotSuffice) {
  compare("jerked", jerked_bar(), true, 1);
  compare("torn for longer", torn_bar_for_longer(), true, 1);
  if (world_.is_root()) {
    EXPECT_EQ(n_again_in_double_, 1) << "what was done in double is not done again";
  }
}

/// Mixed precision would suffice for this bar, so no alarm reveals a phase with the wrong precision.
TEST_F(Checkpoints, GoOnInTheirOwnPrecision) {
  const auto mixed = test::pulled_bar(torn_bar());
  auto in_double = mixed;
  in_double.time.precision = input::Precision::double_;
  auto expected = run_sample(world_, in_double, in_double.output, part(world_));
  expected.counts.range_restarts = 1;
  int n_running = 0, n_between = 0;
  // One in each of the two phases, and one between them.
  for (int n = 1; n < 40 && (n_running < 2 || n_between < 1); ++n) {
    const auto saved = suspended_at_poll(n, in_double);
    bool is_saved = !saved.empty();
    MPI_Bcast(&is_saved, 1, MPI_CXX_BOOL, 0, world_.get());
    if (!is_saved) continue;
    const auto checkpoint = share_checkpoint(world_, saved);
    EXPECT_EQ(checkpoint.precision, input::Precision::double_);
    int& n_of_kind = checkpoint.running ? n_running : n_between;
    const int n_ended = static_cast<int>(checkpoint.ended.size());
    if (n_of_kind > (checkpoint.running ? n_ended : 0)) continue;
    ++n_of_kind;
    if (world_.is_root())
      std::printf("look %d: %d phases have ended, %s\n", n, n_ended,
                  checkpoint.running ? "one runs" : "none runs");
    SampleControl control;
    control.checkpoint = saved;
    const auto result = run_sample(world_, mixed, mixed.output, part(world_), control);
    if (world_.is_root()) test::expect_same_course(expected, result);
  }
  EXPECT_EQ(n_running, 2);
  EXPECT_EQ(n_between, 1);

  std::string lines;
  SampleControl control;
  control.log = [&](const std::string& line) { lines += line + "\n"; };
  control.checkpoint = suspended_at_poll(10, mixed);
  const auto result = run_sample(world_, in_double, in_double.output, part(world_), control);
  if (world_.is_root()) {
    EXPECT_NE(lines.find("the checkpoint is not used: it was made in mixed numbers"), std::string::npos)
        << lines;
    expected.counts.range_restarts = 0;
    test::expect_same_course(expected, result);
  }
}

/// A run asked to park during quasi-static loading, between a phase restored from its checkpoint and the
/// phase that the checkpoint continues.
TEST_F(Checkpoints, StayWhereARunDoesNotReachThem) {
  const auto parameters = test::pulled_bar(torn_bar());
  const auto whole = run_sample(world_, parameters, parameters.output, part(world_));
  std::vector<std::byte> saved;
  bool is_found = false;
  for (int n = 1; !is_found; ++n) {
    ASSERT_LT(n, 40) << "no phase runs after one that has arrested";
    saved = suspended_at_poll(n, parameters);
    if (!parallel::share(world_, !saved.empty())) continue;
    const auto checkpoint = share_checkpoint(world_, saved);
    is_found = checkpoint.running && !checkpoint.ended.empty();
  }
  SampleControl control;
  control.checkpoint = saved;
  bool is_replayed = false;
  int n_saved = 0;
  control.log = [&](const std::string& line) {
    is_replayed = is_replayed || line.find("is taken from the checkpoint") != line.npos;
  };
  control.stop = [&] { return is_replayed; };
  control.save = [&](std::span<const std::byte> bytes) {
    saved.assign(bytes.begin(), bytes.end());
    ++n_saved;
  };
  EXPECT_TRUE(run_sample(world_, parameters, parameters.output, part(world_), control).suspended);
  EXPECT_EQ(n_saved, 0) << "an earlier moment replaced a later one";

  SampleControl again;
  bool is_continued = false;
  again.log = [&](const std::string& line) {
    is_continued = is_continued || line.find("continues at step") != line.npos;
  };
  again.checkpoint = saved;
  const auto result = run_sample(world_, parameters, parameters.output, part(world_), again);
  if (!world_.is_root()) return;
  EXPECT_TRUE(is_replayed);
  EXPECT_TRUE(is_continued);
  test::expect_same_course(whole, result);
}

TEST_F(Checkpoints, OfAnotherSampleOrCutShortAreNotUsed) {
  const auto parameters = test::pulled_bar(torn_bar());
  const auto whole = run_sample(world_, parameters, parameters.output, part(world_));
  std::vector<std::byte> saved;
  int n_looks = 0;
  SampleControl control;
  control.stop = [&] { return ++n_looks > 12; };
  control.save = [&](std::span<const std::byte> bytes) { saved.assign(bytes.begin(), bytes.end()); };
  auto other = parameters;
  other.fracture.strength *= 1.01;
  EXPECT_TRUE(run_sample(world_, other, other.output, part(world_), control).suspended);
  if (world_.is_root()) {
    ASSERT_FALSE(saved.empty());
  }
  for (const bool is_cut : {false, true}) {
    if (is_cut) saved.resize(saved.size() / 2);
    std::string lines;
    SampleControl again;
    again.log = [&](const std::string& line) { lines += line + "\n"; };
    again.checkpoint = saved;
    const auto result = run_sample(world_, parameters, parameters.output, part(world_), again);
    if (!world_.is_root()) continue;
    EXPECT_NE(lines.find("the checkpoint is not used"), std::string::npos) << lines;
    test::expect_same_course(whole, result);
  }
}

TEST_F(Checkpoints, ThatCannotBeKeptDoNotEndTheSample) {
  std::string lines;
  SampleControl control;
  control.log = [&](const std::string& line) { lines += line + "\n"; };
  control.save = [](std::span<const std::byte>) { throw std::runtime_error("No space left on device"); };
  control.checkpoint_interval = 0;
  const auto result = run_sample(world_, torn_bar(), torn_bar().output, part(world_), control);
  EXPECT_FALSE(result.suspended);
  if (world_.is_root()) {
    EXPECT_NE(lines.find("the checkpoint could not be written: No space left on device"), std::string::npos);
    EXPECT_FALSE(result.breaks.empty());
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
