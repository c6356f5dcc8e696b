// SPDX-License-Identifier: GPL-3.0-or-later
// Springs that the program does not know: as part of a linear equilibrium, and where loads grow in
// increments.
#include "common/index.h"
#include "dynamics/first_break_prediction.h"
#include "dynamics/quasi_static.h"
#include "dynamics/sample_run.h"
#include "parallel/agreement.h"

#include "support/box_mesh.h"
#include "support/springs.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;
using test::SpringBed;

/// A bar without lateral contraction, pulled towards springs.
struct PulledBar {
  static constexpr double length = 0.008, area = 0.002 * 0.002;

  PulledBar() {
    parameters.materials[0].poisson_ratio = 0;
    parameters.boundaries = test::uniform_pull();
  }
  double stiffness() const { return parameters.materials[0].youngs_modulus * area / length; }
  double stretch() const { return 35e6 * length / parameters.materials[0].youngs_modulus; }  // at a break
  SpringBed bed(SpringBed::Kind kind) const {
    return {.kind = kind, .condition = 3, .stiffness = stiffness()};
  }

  input::Parameters parameters = test::brittle({0.002, 0.002, length});
  geometry::Subdomain subdomain =
      test::whole(test::make_box({.size = {0.002, 0.002, length}, .cells = {2, 2, 8}}));
  parallel::Communicator self{MPI_COMM_SELF};
};

TEST(Increments, FindTheBreakOfABarThatMeetsAStop) {
  PulledBar bar;
  for (const double share : {0.0, 0.5, 0.99, 1.5}) {
    SpringBed bed = bar.bed(SpringBed::Kind::one_sided);
    bed.gap = share * bar.stretch();
    SampleSetup setup(bar.self, bar.parameters, bar.subdomain, 0, {test::make_springs(bed)});
    EnergyAccount account(bar.self, setup.body);
    QuasiStaticLoading loading(setup.motion_context(), 1e-5);
    loading.load_at_start(account);
    const auto outlook = first_break(loading, setup.loads, account);
    const double exact = bar.stiffness() * (bar.stretch() + std::max(0.0, bar.stretch() - bed.gap));
    std::printf("gap %.3g um: breaks at %.9g N, exactly %.9g N, %lld solves\n", 1e6 * bed.gap, outlook.load,
                exact, static_cast<long long>(loading.n_solves()));
    EXPECT_NEAR(outlook.load / exact, 1, 1e-8);
    EXPECT_LT(loading.n_solves(), 60);
    EXPECT_LT(loading.residual(), 1e-7);
  }
}

TEST(Increments, CloseTheEnergyAccountOfABarThatMeetsAStop) {
  PulledBar bar;
  SpringBed bed = bar.bed(SpringBed::Kind::one_sided);
  bed.gap = 0.5 * bar.stretch();
  SampleControl control;
  control.more_terms = {test::make_springs(bed)};
  bar.parameters.fracture.strength = 1e9;
  bar.parameters.boundaries[3].history = {{0, 0}, {10, 200}};
  bar.parameters.boundaries[3].value = {0, 0, 1};
  bar.parameters.boundaries[3].rate = {};
  const auto result = run_sample(bar.self, bar.parameters, bar.parameters.output, bar.subdomain, control);
  const double u = (200 + bar.stiffness() * bed.gap) / (2 * bar.stiffness());
  const double energy = 0.5 * bar.stiffness() * (u * u + std::pow(u - bed.gap, 2));
  const EnergyRow& last = result.history.back().energy;
  std::printf("external %.6g J, strain %.6g J, exactly %.6g J, %zu rows\n", last.external, last.strain,
              energy, result.history.size());
  EXPECT_EQ(result.outcome, Outcome::unbroken);
  EXPECT_NEAR(last.strain / energy, 1, 1e-7);
  EXPECT_NEAR(last.external / energy, 1, 1e-3);
}

TEST(Increments, CloseTheEnergyAccountOfABarThatADrivenStopPushes) {
  PulledBar bar;
  SpringBed bed = bar.bed(SpringBed::Kind::one_sided);
  bed.gap = 2e-5;
  bed.approach = mechanics::LoadCurve(1e-4, 0, {{0, 0}, {3, 1}, {4, 0.5}});
  SampleControl control;
  control.more_terms = {test::make_springs(bed)};
  bar.parameters.boundaries[3].rate = {};
  const auto result = run_sample(bar.self, bar.parameters, bar.parameters.output, bar.subdomain, control);
  const HistoryRow& row = result.history.back();
  const double u = -(5e-5 - bed.gap) / 2, energy = bar.stiffness() * u * u;
  std::printf("external %.6g J, strain %.6g J, exactly %.6g J; springs %.6g N, exactly %.6g N\n",
              row.energy.external, row.energy.strain, energy, row.records.at(0).value, bar.stiffness() * u);
  EXPECT_NEAR(row.energy.strain / energy, 1, 1e-6);
  EXPECT_NEAR(row.energy.external / energy, 1, 1e-3);
  EXPECT_NEAR(row.records.at(0).value / (bar.stiffness() * u), 1, 1e-6);
}

TEST(Increments, AreSuspendedOnRequest) {
  PulledBar bar;
  SpringBed bed = bar.bed(SpringBed::Kind::one_sided);
  bed.gap = 0.5 * bar.stretch();
  bar.parameters.fracture.strength = 1e9;
  bar.parameters.boundaries[3].history = {{0, 0}, {10, 200}};
  bar.parameters.boundaries[3].value = {0, 0, 1};
  bar.parameters.boundaries[3].rate = {};
  SampleSetup setup(bar.self, bar.parameters, bar.subdomain, 0, {test::make_springs(bed)});
  EnergyAccount account(bar.self, setup.body);
  QuasiStaticLoading loading(setup.motion_context(), 1e-5);
  loading.load_at_start(account);
  int n = 0;
  EXPECT_EQ(loading.advance(account, [&] { return ++n == 3; }), QuasiStaticEnd::suspended);
  EXPECT_LT(loading.time(), 9);
  EXPECT_EQ(loading.advance(account), QuasiStaticEnd::no_load);
  EXPECT_EQ(loading.time(), 10);
}

TEST(Increments, LetABlockLiftFromAFoundationThatOnlyPushes) {
  // A stiff block under an eccentric force: on a length c = 3 (L / 2 - e) it presses with a triangle of
  // pressure.
  const double length = 0.02, eccentricity = 0.006, force = 1, stiffness = 1e5;
  auto parameters = test::brittle({0.002, length, 0.006});
  auto hinge = test::boundary(Face::y_min, BoundaryKind::fix, {false, true, false});
  hinge.region[2] = {0, 0};
  auto push = test::boundary(Face::z_max, BoundaryKind::force, {}, {0, 0, -force});
  push.region[1] = {length / 2 + eccentricity - 0.001, length / 2 + eccentricity + 0.001};
  parameters.boundaries = {test::boundary(Face::x_min, BoundaryKind::fix, {true, false, false}), hinge, push,
                           test::boundary(Face::z_min, BoundaryKind::force, {}, {0, 0, 1e-12})};
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto subdomain = test::whole(test::make_box({.size = {0.002, length, 0.006}, .cells = {2, 40, 6}}));
  const SpringBed bed{.kind = SpringBed::Kind::one_sided, .condition = 3, .side = -1, .stiffness = stiffness};
  SampleSetup setup(self, parameters, subdomain, 0, {test::make_springs(bed)});
  EXPECT_TRUE(setup.free_motions().empty());
  const QuasiStaticLoading loading(setup.motion_context(), 1e-5);
  const double contact = 3 * (length / 2 - eccentricity), exact = 2 * force * length / (stiffness * contact);
  double deepest = 0, pressed = length;
  for (std::size_t n = 0; n < subdomain.nodes.size(); ++n) {
    if (subdomain.nodes[n][2] != 0) continue;
    const double u = -loading.displacement().owned()[3 * n + 2];
    deepest = std::max(deepest, u);
    if (u > 0) pressed = std::min(pressed, subdomain.nodes[n][1]);
  }
  std::printf("pressed %.4g of %.4g um deep, on %.4g of %.4g mm, %lld solves\n", 1e6 * deepest, 1e6 * exact,
              1e3 * (length - pressed), 1e3 * contact, static_cast<long long>(loading.n_solves()));
  EXPECT_NEAR(deepest / exact, 1, 0.02);
  EXPECT_NEAR(length - pressed, contact, length / 40);
  EXPECT_LT(loading.n_solves(), 20);
}

/// A bar that breaks little by little, held back by springs.
SampleResult spring_bar(SpringBed::Kind kind, double stiffness) {
  auto parameters = test::brittle({0.004, 0.004, 0.012});
  parameters.time.arrest = 1e-30;
  parameters.boundaries = {
      test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}),
      test::boundary(Face::z_max, BoundaryKind::displacement, {false, false, true}, {}, {0, 0, 1e-6}),
      test::boundary(Face::y_max, BoundaryKind::force, {}, {}, {0, 0.1, 0})};
  SampleControl control;
  control.more_terms = {
      test::make_springs({.kind = kind, .condition = 2, .component = 1, .stiffness = stiffness})};
  const auto mesh = test::make_box({.size = {0.004, 0.004, 0.012}, .cells = {3, 3, 9}, .disturbance = 0.2});
  return run_sample(parallel::Communicator(MPI_COMM_SELF), parameters, parameters.output, test::whole(mesh),
                    control);
}

TEST(Increments, BreakWhatTheClosedFormBreaks) {
  const auto closed = spring_bar(SpringBed::Kind::linear, 1e5),
             increments = spring_bar(SpringBed::Kind::in_increments, 1e5);
  std::printf("%s after %zu breaks, %s after %zu; %lld and %lld solves, energy errors %.1e and %.1e\n",
              to_string(closed.outcome).c_str(), closed.breaks.size(), to_string(increments.outcome).c_str(),
              increments.breaks.size(), static_cast<long long>(closed.counts.static_solves),
              static_cast<long long>(increments.counts.static_solves), closed.energy_error,
              increments.energy_error);
  ASSERT_GT(closed.breaks.size(), 20U);
  EXPECT_EQ(closed.breaks.size(), increments.breaks.size());
  EXPECT_EQ(closed.outcome, increments.outcome);
  EXPECT_NEAR(increments.first_break_load / closed.first_break_load, 1, 1e-7);
  for (std::size_t n = 0; n < 20; ++n) {
    EXPECT_EQ(closed.breaks[n].tetrahedron, increments.breaks[n].tetrahedron) << n;
    EXPECT_NEAR(increments.breaks[n].load_time / closed.breaks[n].load_time, 1, 1e-6) << n;
  }
  EXPECT_LT(closed.energy_error, 1e-6);
  EXPECT_LT(increments.energy_error, 1e-6);
  EXPECT_NE(spring_bar(SpringBed::Kind::linear, 1).first_break_load, closed.first_break_load);
}

/// A force that turns round with the displacement, so that no iteration finds its equilibrium.
class Flipping final : public Term {
public:
  bool is_linear() const override { return false; }
  void add_responses(double, std::span<const double> displacement,
                     std::vector<NodeResponse>& responses) const override {
    NodeResponse response;
    response.node = static_cast<std::int32_t>(displacement.size() / 3) - 1;
    response.force[2] = displacement.back() > 0 ? -1 : 1;
    responses.push_back(response);
  }
};

TEST(Increments, SayWhereTheyFindNoEquilibrium) {
  PulledBar bar;
  SampleControl control;
  control.more_terms = {
      [](const MotionContext&, const MotionState&, std::int32_t) { return std::make_unique<Flipping>(); }};
  const auto run = [&] {
    run_sample(bar.self, bar.parameters, bar.parameters.output, bar.subdomain, control);
  };
  EXPECT_THAT(run, testing::ThrowsMessage<std::runtime_error>(
                       testing::HasSubstr("no equilibrium at t = 0 s: after 20 steps of Newton's method")));
}

TEST(Foundation, OfLinearSpringsHoldsABodyInEquilibriumAndMotion) {
  // Held along z by nothing else.
  PulledBar bar;
  bar.parameters.boundaries[2].kind = BoundaryKind::force;
  bar.parameters.boundaries[2].value = {0, 0, 1e-12};
  bar.parameters.boundaries[2].components = {};
  bar.parameters.time.arrest = 2e-6;
  SpringBed bed = bar.bed(SpringBed::Kind::linear);
  bed.condition = 2;
  SampleControl control;
  EXPECT_THROW(run_sample(bar.self, bar.parameters, bar.parameters.output, bar.subdomain, control),
               parallel::AgreedError);
  control.more_terms = {test::make_springs(bed)};
  for (const auto engine : {input::Engine::fixed_point, input::Engine::petsc}) {
    bar.parameters.time.engine = engine;
    const auto result = run_sample(bar.self, bar.parameters, bar.parameters.output, bar.subdomain, control);
    const auto& equilibrium =
        *(std::ranges::find_if(result.history, [](const auto& row) { return row.phase > 0; }) - 1);
    std::printf("%s after %zu breaks at %.9g N, displaced by %.6g um, exactly %.6g um; energy error %.1e\n",
                to_string(result.outcome).c_str(), result.breaks.size(), result.first_break_load,
                1e6 * equilibrium.load_displacement, 2e6 * bar.stretch(), result.energy_error);
    EXPECT_NEAR(result.first_break_load / (35e6 * bar.area), 1, 1e-6);
    EXPECT_NEAR(equilibrium.load_displacement / (2 * bar.stretch()), 1, 1e-6);
    EXPECT_GE(result.counts.dynamic_phases, 1);
    EXPECT_LT(result.energy_error, 1e-4);
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
