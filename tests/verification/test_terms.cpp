// SPDX-License-Identifier: GPL-3.0-or-later
// A contribution to the motion that the program does not know: springs at all nodes, on which a body swings
// as a whole.
#include "dynamics/moving_body.h"
#include "dynamics/term.h"
#include "parallel/agreement.h"

#include "support/box_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

/// Springs of mass times the square of a frequency at each node.
class Springs final : public Term {
public:
  Springs(const MotionContext& context, double frequency, std::int32_t nodes_per_block)
      : context_(context),
        square_(frequency * frequency),
        nodes_per_block_(nodes_per_block),
        remainder_(context.body->operators().node_mass.size()) {}

  bool acts_on(std::size_t) const override { return true; }
  void after_kick(std::size_t block, const Substep& substep, MovingNodes& nodes) override {
    const auto first = static_cast<std::int32_t>(block) * nodes_per_block_;
    const auto n = static_cast<std::int32_t>(remainder_.size());
    for (std::int32_t node = first; node < std::min(first + nodes_per_block_, n); ++node)
      for (int c = 0; c < 3; ++c)
        nodes.kick(node, c, substep.kick, -stiffness(node) * nodes.displacement(node, c),
                   remainder_[index(node)][index(c)]);
  }
  Demand demand(double, double) const override { return {.velocity = 20}; }
  bool stores() const override { return true; }
  void add_stored(const parallel::NodeField& displacement, std::vector<double>& sum) const override {
    const auto u = displacement.owned();
    for (std::size_t i = 0; i < u.size(); ++i)
      sum.push_back(0.5 * stiffness(static_cast<std::int32_t>(i / 3)) * u[i] * u[i]);
  }
  std::vector<parallel::NumberedRows> save() const override {
    std::vector<parallel::NumberedRows> rows;
    for (std::size_t c = 0; c < 3; ++c) {
      parallel::NumberedRows local;
      for (std::size_t n = 0; n < remainder_.size(); ++n)
        local.add(context_.body->subdomain().layout.number[n], remainder_[n][c]);
      rows.push_back(parallel::gather_rows(*context_.group, local));
    }
    return rows;
  }
  void restore(const std::vector<parallel::NumberedRows>& rows) override {
    for (std::size_t n = 0; n < remainder_.size(); ++n)
      for (std::size_t c = 0; c < 3; ++c)
        remainder_[n][c] = rows.at(c).number_at(context_.body->subdomain().layout.number[n]);
  }

private:
  double stiffness(std::int32_t node) const {
    return context_.body->operators().node_mass[index(node)] * square_;
  }

  MotionContext context_;
  double square_;
  std::int32_t nodes_per_block_;
  std::vector<std::array<double, 3>> remainder_;
};

using Make = std::function<std::unique_ptr<MovingBody>(const MotionContext&, MotionState&)>;

class SpringBorneBlock : public testing::Test {
protected:
  static constexpr double frequency = 2 * std::numbers::pi * 1e4, step = 2e-8;
  static constexpr std::array<double, 3> start{1e-4, -2e-4, 3e-4};

  MotionContext context() {
    MotionContext result{&self_, &body_, &loads_, &law_};
    result.more_terms = {[](const MotionContext& of, const MotionState&, std::int32_t nodes_per_block) {
      return std::make_unique<Springs>(of, frequency, nodes_per_block);
    }};
    return result;
  }
  MotionState displaced() const {
    MotionState state{parallel::NodeField(self_, subdomain_.layout),
                      parallel::NodeField(self_, subdomain_.layout)};
    const auto u = state.displacement.local();
    for (std::size_t i = 0; i < u.size(); ++i) u[i] = start[i % 3];
    return state;
  }
  static void run(MovingBody& motion, int first, int n_steps) {
    for (int i = first; i < first + n_steps; ++i)
      motion.step(splitting(input::Integrator::verlet).even, step, i * step);
  }

  parallel::Communicator self_{MPI_COMM_SELF};
  geometry::Subdomain subdomain_ =
      test::whole(test::make_box({.size = {0.004, 0.006, 0.012}, .cells = {2, 3, 6}, .disturbance = 0.2}));
  fracture::BreakableBody body_{subdomain_, test::epoxy()};
  mechanics::Conditions loads_;
  fracture::FractureLaw law_ = test::unbreakable(subdomain_);
  const std::vector<std::pair<const char*, Make>> engines_{
      {"plain", [](const auto& of, auto& state) { return make_reference_motion(of, 0, state); }},
      {"mixed",
       [](const auto& of, auto& state) {
         return make_fixed_point_motion(of, input::Precision::mixed, 0, 1e-4, state);
       }},
      {"double", [](const auto& of, auto& state) {
         return make_fixed_point_motion(of, input::Precision::double_, 0, 1e-4, state);
       }}};
};

TEST_F(SpringBorneBlock, SwingsAtItsFrequency) {
  for (const auto& [name, make] : engines_) {
    auto state = displaced();
    const auto motion = make(context(), state);
    motion->read(state);
    const double stored = motion->strain_energy(state);
    EXPECT_GT(stored, 0) << name;
    run(*motion, 0, 3333);  // two thirds of a period
    motion->read(state);
    ASSERT_FALSE(motion->failure()) << name;
    double error = 0, kinetic = 0;
    for (std::size_t i = 0; i < state.velocity.owned().size(); ++i) {
      error = std::max(
          error, std::abs(state.displacement.owned()[i] / start[i % 3] - std::cos(frequency * 3333 * step)));
      kinetic += 0.5 * body_.operators().node_mass[i / 3] * std::pow(state.velocity.owned()[i], 2);
    }
    const double imbalance = std::abs((kinetic + motion->strain_energy(state)) / stored - 1);
    std::printf("%s: displacement off by %.1e, energy by %.1e\n", name, error, imbalance);
    EXPECT_LT(error, name == std::string("mixed") ? 1e-3 : 1e-5) << name;
    EXPECT_LT(imbalance, name == std::string("mixed") ? 1e-3 : 1e-5) << name;
  }
}

TEST_F(SpringBorneBlock, GoesOnFromItsCheckpoint) {
  for (const auto& [name, make] : engines_) {
    auto state = displaced(), again = displaced();
    const auto motion = make(context(), state);
    run(*motion, 0, 501);
    const MotionCheckpoint checkpoint = motion->save();
    const auto restored = make(context(), again);
    restored->restore(checkpoint);
    for (MovingBody* one : {motion.get(), restored.get()}) run(*one, 501, 400);
    motion->read(state);
    restored->read(again);
    EXPECT_TRUE(std::ranges::equal(again.displacement.owned(), state.displacement.owned())) << name;
    EXPECT_TRUE(std::ranges::equal(again.velocity.owned(), state.velocity.owned())) << name;
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
