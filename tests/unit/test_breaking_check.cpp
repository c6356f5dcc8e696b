// SPDX-License-Identifier: GPL-3.0-or-later
// Breaking at the ends of steps, with scripted stresses.
#include "dynamics/breaking_check.h"
#include "fracture/crack_vicinity.h"

#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

constexpr double strength = 35e6, stable_step = 6e-8;
constexpr std::int32_t loaded = 2;

/// One tetrahedron under time-dependent uniaxial tension, and the others under a share of it. Only that one
/// is reported.
class ScriptedMotion final : public MovingBody {
public:
  ScriptedMotion(const fracture::BreakableBody& body, std::function<double(double)> stress, double share,
                 double around)
      : body_(&body), stress_(std::move(stress)), share_(share), around_(around) {}

  void step(std::span<const Stage>, double time_step, double) override {
    before_ = {time_, before_[0]};
    time_ += time_step;
  }
  std::span<const std::int32_t> overloaded() override {
    overloaded_.clear();
    if (!body_->is_broken(loaded) && stress_(time_) > share_ * strength) overloaded_.push_back(loaded);
    return overloaded_;
  }
  mechanics::Symmetric strain(std::int32_t t) const override { return strain_at(t, time_); }
  mechanics::Symmetric strain_before(std::int32_t t, int n_steps) const override {
    return strain_at(t, before_[n_steps == 1 ? 0 : 1]);
  }
  void relative_displacements(std::span<const std::int32_t>, int, std::span<Vector>) const override {}
  void release(std::span<const std::int32_t>) override {}
  void read(MotionState&) const override {}
  double strain_energy(const MotionState&) const override { return 0; }
  double external_work(double, const MotionState&) const override { return 0; }
  void end_loads(double, const mechanics::NodesOfConditions&, const MotionState&) override {}
  MotionCheckpoint save() const override { return {}; }
  void restore(const MotionCheckpoint&) override {}
  std::int64_t n_forces() const override { return 0; }

  double time() const { return time_; }

private:
  mechanics::Symmetric strain_at(std::int32_t t, double time) const {
    const auto epoxy = test::epoxy();
    const double along = (t == loaded ? 1 : around_) * stress_(time) / epoxy.youngs_modulus,
                 across = -epoxy.poisson_ratio * along;
    return {across, across, along, 0, 0, 0};
  }

  const fracture::BreakableBody* body_;
  std::function<double(double)> stress_;
  double share_, around_;
  std::array<double, 2> before_{};
  double time_ = 0;
  std::vector<std::int32_t> overloaded_;
};

class ScriptedBreaking : public testing::Test {
protected:
  struct End {
    double break_time;  // or infinity
    double impulse;
  };

  /// @param stress as a function of time, starting at 0
  /// @param restart recreates the check after this many steps
  End run(const std::function<double(double)>& stress, double step, int n_steps, double impulse = 1e4,
          int restart = -1) const {
    return run(stress, step, n_steps, impulse, restart, false, 0);
  }

  /// @param by_means nucleation by means around nodes
  /// @param around stress of the other tetrahedra over that of the loaded one
  /// @param cracked breaks one of these first
  End run(const std::function<double(double)>& stress, double step, int n_steps, double impulse, int restart,
          bool by_means, double around, bool cracked = false) const {
    const auto mesh = test::make_box({.cells = {1, 1, 1}});
    const auto subdomain = test::whole(mesh);
    fracture::BreakableBody body(subdomain, test::epoxy());
    auto criterion = std::make_unique<fracture::TulerButcher>(
        input::Fracture{.strength = strength, .exponent = 2}, impulse,
        std::vector<double>(subdomain.tetrahedra.size(), strength), step);
    const parallel::Communicator self(MPI_COMM_SELF);
    auto vicinity = std::make_unique<fracture::CrackVicinity>(
        body, *criterion, nullptr, std::span<const double>(), std::span<const fracture::SquareEnd>(),
        std::vector<double>(subdomain.tetrahedra.size(), 1e-3), by_means);
    const double share = criterion->screening_share(stable_step);
    fracture::FractureLaw law(std::move(criterion), share, std::move(vicinity));
    if (cracked) body.release(loaded + 1, {}, 0, 0);
    law.follow_cracks(self);
    const std::size_t n_broken = body.breaks().size();
    const MotionContext context{.group = &self, .body = &body, .loads = nullptr, .law = &law};
    ScriptedMotion motion(body, stress, share, around);
    std::unique_ptr<BreakingCheck> check;
    for (int i = 0; i < n_steps && body.breaks().size() == n_broken; ++i) {
      if (i == 0 || i == restart) {
        check = make_breaking_check(context, motion);
        check->start();
      }
      motion.step({}, step, 0);
      for (const auto t : check->end_step(i + 1)) body.release(t, motion.strain(t), 0, motion.time());
    }
    return {body.breaks().size() == n_broken ? INFINITY : body.breaks().back().phase_time,
            law.criterion().memory()[loaded]};
  }
};

TEST_F(ScriptedBreaking, OfConstantRateIsAtTheEndOfAStepNearestToTheMomentOfFailure) {
  const double rate = 3e6 / 5e-8;
  const double needed = std::cbrt(3 * 1e4 / (rate * rate));  // after reaching the strength
  for (const double step : {1e-9, 5e-9, 1.3e-8, 2.7e-8, 5.4e-8}) {
    double mean = 0;
    const int n_phases = 40;
    for (int phase = 0; phase < n_phases; ++phase) {
      const double crossing = (8 + (phase + 0.5) / n_phases) * step;
      const auto stress = [&](double t) { return strength + rate * (t - crossing); };
      const double late = run(stress, step, 200).break_time - (crossing + needed);
      EXPECT_LE(std::abs(late), (0.5 + 1e-6) * step) << "step " << step << ", phase " << phase;
      mean += late / n_phases;
    }
    std::printf("step %4.1f ns: %+.4f steps late on average\n", 1e9 * step, mean / step);
    EXPECT_NEAR(mean, 0, 0.03 * step);  // 40 phase shifts
  }
}

TEST_F(ScriptedBreaking, ForeseesAStressThatRisesFasterAndFaster) {
  // Constant at 5 MPa below the strength, then after about 200 ns 3.5 MPa above it within 50 ns, as at a
  // crack front.
  const double step = 5.4e-8;
  double mean = 0;
  const int n_phases = 40;
  for (int phase = 0; phase < n_phases; ++phase) {
    const double start = (2 + (phase + 0.5) / n_phases) * step;
    const auto stress = [&](double t) {
      const double since = std::max(t - start, 0.0) / 1.5e-7;
      return strength - 5e6 + 5e6 * since * since;
    };
    mean += (run(stress, step, 20).break_time - run(stress, 1e-10, 10000).break_time) / n_phases;
  }
  std::printf("%+.3f steps late on average\n", mean / step);
  EXPECT_NEAR(mean, 0, 0.05 * step);
}

TEST_F(ScriptedBreaking, CountsTheStepInWhichTheStressFalls) {
  // From 5 MPa below the strength to 2 MPa above and back.
  const double rate = 7e6 / 3e-8;
  const auto stress = [&](double t) { return strength + 2e6 - rate * std::abs(t - 3e-8); };
  const double expected = 2 * std::pow(2e6, 3) / (3 * rate);
  for (const int n_steps : {2, 6, 60}) {
    const double step = 6e-8 / n_steps;
    EXPECT_NEAR(run(stress, step, n_steps, 1e9).impulse, expected, 1e-9 * expected) << n_steps << " steps";
    for (int restart = 1; restart < n_steps; ++restart)
      EXPECT_NEAR(run(stress, step, n_steps, 1e9, restart).impulse, expected, 1e-9 * expected)
          << n_steps << " steps, made anew after " << restart;
  }
}

/// Of the six tetrahedra of a cube, of one volume, two meet at each corner but the ends of their diagonal.
TEST_F(ScriptedBreaking, AwayFromCracksIsByTheSmallerOfTheOwnStressAndTheMeanAroundACorner) {
  const double step = 1e-9, rate = 3e6 / 5e-8;
  const auto stress = [&](double t) { return rate * t; };
  const auto time_at = [&](double around, bool cracked = false) {
    return run(stress, step, 4000, 1e4, -1, true, around, cracked).break_time;
  };
  const double alone = run(stress, step, 4000).break_time;
  EXPECT_EQ(time_at(1), alone);
  const double delay = alone - strength / rate;
  for (const double around : {0.5, 0.8}) {
    const double largest = (1 + around) / 2;
    const double at_strength = strength / rate / largest;
    EXPECT_NEAR(time_at(around), at_strength + delay * std::pow(largest, -2.0 / 3), 1.5 * step) << around;
    EXPECT_EQ(time_at(around, true), alone) << "at a crack by its own stress";
  }
}

TEST_F(ScriptedBreaking, IsNotForAStressThatStaysBelowTheStrength) {
  const auto stress = [](double t) { return 0.999 * strength * (1 - std::exp(-t / 1e-6)); };
  EXPECT_EQ(run(stress, 5.4e-8, 1000).break_time, INFINITY);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
