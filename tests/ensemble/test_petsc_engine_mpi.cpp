// SPDX-License-Identifier: GPL-3.0-or-later
// Dynamics with PETSc's matrix and vectors, compared with the plain loop over tetrahedra and with the
// fixed-point engine, on any number of ranks and after restarts.
#include "common/index.h"
#include "dynamics/checkpoint.h"
#include "dynamics/explicit_phase.h"
#include "dynamics/sample_run.h"
#include "fracture/toughness.h"
#include "parallel/collectives.h"

#include "mechanics/petsc_stiffness.h"
#include "support/box_mesh.h"
#include "support/effort.h"
#include "support/group.h"
#include "support/partitions.h"
#include "support/same_result.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <span>
#include <string>
#include <tuple>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using input::Engine;
using plane::Face;

input::Parameters torn_bar() {
  auto parameters = test::torn_bar(test::is_full() ? 1e-8 : 2e-8);
  parameters.time.engine = Engine::petsc;
  parameters.time.precision = input::Precision::double_;
  return parameters;
}

class PetscEngine : public testing::Test {
protected:
  geometry::Subdomain part(const parallel::Communicator& group) const {
    return geometry::split(mesh_, geometry::partition(mesh_, group.size()))[index(group.rank())];
  }

  SampleResult sample(const input::Parameters& parameters) const {
    return run_sample(world_, parameters, parameters.output, part(world_));
  }

  /// The largest difference of owned values relative to the largest value. Collective.
  double difference(std::span<const double> a, std::span<const double> b) const {
    double worst = 0, largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      worst = std::max(worst, std::abs(a[i] - b[i]));
      largest = std::max(largest, std::abs(b[i]));
    }
    return parallel::largest_of_all(world_, worst) / parallel::largest_of_all(world_, largest);
  }

  using Event = std::tuple<std::int64_t, double, double, int>;
  static std::vector<Event> events(const std::vector<fracture::Break>& breaks) {
    std::vector<Event> all;
    for (const auto& one : breaks) all.emplace_back(one.tetrahedron, one.load_time, one.phase_time, one.cut);
    return all;
  }

  /// The sample in pieces, each suspended after a number of polls. Complete on rank 0.
  /// @param on_fewer every second piece is computed on rank 0 alone
  SampleResult in_pieces(const input::Parameters& parameters, bool on_fewer) {
    std::vector<std::byte> saved;
    SampleResult result;
    n_suspended_ = 0;
    bool is_suspended = true;
    for (int piece = 0; is_suspended; ++piece) {
      const parallel::Communicator& group = on_fewer && piece % 2 == 1 ? self_ : world_;
      int n_looks = 0;
      SampleControl control;
      control.stop = [&] { return group.rank() == group.size() - 1 && ++n_looks > 3 * (piece + 1); };
      control.save = [&](std::span<const std::byte> bytes) { saved.assign(bytes.begin(), bytes.end()); };
      control.log = [&](const std::string& line) { EXPECT_EQ(line.find("is not used"), line.npos) << line; };
      if (group.is_root()) control.checkpoint = saved;
      if (group.size() == world_.size() || world_.is_root())
        result = run_sample(group, parameters, parameters.output, part(group), control);
      is_suspended = result.suspended;
      MPI_Bcast(&is_suspended, 1, MPI_CXX_BOOL, 0, world_.get());
      n_suspended_ += is_suspended ? 1 : 0;
    }
    return result;
  }

  parallel::Communicator world_{test::group()}, self_{MPI_COMM_SELF};
  geometry::Realization mesh_ =
      test::make_box({.size = torn_bar().specimen.size, .cells = {3, 5, 14}, .disturbance = 0.2});
  int n_suspended_ = 0;
};

/// With fully or partly broken tetrahedra, before and after the matrix is assembled.
TEST_F(PetscEngine, MultipliesAsThePlainLoopDoes) {
  double worst = 0;
  for (const auto release : {input::Release::element, input::Release::facet}) {
    for (const auto& [name, make] : test::hostile_partitions(torn_bar().specimen.size)) {
      SCOPED_TRACE(name);
      const auto subdomain = geometry::split(mesh_, make(mesh_, world_.size()))[index(world_.rank())];
      fracture::BreakableBody body(subdomain, test::epoxy(), fracture::make_release({.release = release}));
      const auto number_of = [&](std::int32_t t) { return subdomain.tetrahedron_number[index(t)]; };
      const auto break_some = [&](std::int64_t first) {
        const auto n_before = body.changes().size();
        for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t)
          if (number_of(t) % 9 == first) body.release(t, {1e-3, 0, 2e-3, 1e-4, 0, 0}, 0, 0);
        return body.changes().subspan(n_before);
      };
      break_some(4);
      mechanics::PetscStiffness stiffness(world_, subdomain, body.operators(), body.elasticity(),
                                          body.residual_stiffness());
      for (const bool is_updated : {false, true}) {
        if (is_updated) {
          stiffness.update(break_some(7));
          stiffness.assemble();
        }
        parallel::NodeField u(world_, subdomain.layout), force(world_, subdomain.layout);
        for (std::size_t n = 0; n < index(subdomain.layout.n_owned); ++n) {
          auto stream =
              RandomStream(3, 0, "u").substream(static_cast<std::uint64_t>(subdomain.layout.number[n]));
          for (std::size_t i = 0; i < 3; ++i) u.owned()[3 * n + i] = 1e-6 * stream.uniform(-1, 1);
        }
        stiffness.apply(u, force);
        u.update_ghosts();
        std::vector<double> plain(u.local().size());
        body.force().evaluate(u.local(), plain);
        worst = std::max(worst, difference(force.owned(), std::span(plain).first(u.owned().size())));
      }
    }
  }
  if (world_.is_root()) std::printf("%d ranks: product within %.1e\n", world_.size(), worst);
  EXPECT_LT(worst, 1e-13);
}

/// The same phase with both; a break in a different step would affect everything after it.
TEST_F(PetscEngine, MovesAsTheDefinitionDoes) {
  const auto parameters = torn_bar();
  const auto subdomain = part(world_);
  const auto loads = mechanics::make_boundary_loads(world_, parameters, subdomain);
  for (const auto release : {input::Release::element, input::Release::facet}) {
    for (const auto integrator : {input::Integrator::bilateral4, input::Integrator::verlet}) {
      const auto run = [&](const auto& make_motion) {
        fracture::BreakableBody body(subdomain, parameters.material(),
                                     fracture::make_release({.release = release}));
        fracture::FractureLaw law(fracture::make_criterion(
            parameters.fracture_of(0),
            fracture::tetrahedron_strengths(world_, parameters, 0, body).nucleation, *parameters.time.step,
            mechanics::TetrahedronField(parameters.fracture.impulse)));
        const MotionContext context{&world_, &body, &loads, &law};
        const EnergyAccount account(world_, body);
        MotionState state{parallel::NodeField(world_, subdomain.layout),
                          parallel::NodeField(world_, subdomain.layout)};
        PhaseOptions options;
        options.grid = {*parameters.time.step, 700};
        const auto motion = make_motion(context, 0.0, state);
        const auto result =
            run_explicit_phase(context, *motion, splitting(integrator), account, 0, options, state);
        return std::tuple(std::move(state), events(gather_breaks(world_, body.breaks())), result.n_forces);
      };
      const auto [state, breaks, n_forces] = run(make_petsc_motion);
      const auto [plain_state, plain_breaks, n_plain_forces] = run(make_reference_motion);
      const double u = difference(state.displacement.owned(), plain_state.displacement.owned());
      const double v = difference(state.velocity.owned(), plain_state.velocity.owned());
      EXPECT_LT(u, 1e-9);
      EXPECT_LT(v, 1e-7);
      EXPECT_EQ(n_forces, n_plain_forces);
      EXPECT_EQ(breaks, plain_breaks);
      if (!world_.is_root()) continue;
      std::printf("%d ranks: %zu breaks, displacement within %.1e, velocity within %.1e\n", world_.size(),
                  breaks.size(), u, v);
      EXPECT_GT(breaks.size(), 20U) << "the case must break";
    }
  }
}

TEST_F(PetscEngine, BreaksWhatTheFixedPointEngineBreaks) {
  for (auto parameters : {torn_bar(), test::pulled_bar(torn_bar())}) {
    for (const auto release : {input::Release::element, input::Release::facet}) {
      parameters.fracture.release = release;
      parameters.time.engine = Engine::petsc;
      const auto result = sample(parameters);
      parameters.time.engine = Engine::fixed_point;
      const auto expected = sample(parameters);
      if (!world_.is_root()) continue;
      std::printf("%d ranks: %zu breaks, energy error %.1e and %.1e\n", world_.size(), result.breaks.size(),
                  result.energy_error, expected.energy_error);
      EXPECT_GT(result.breaks.size(), 20U) << "the case must break";
      EXPECT_EQ(events(result.breaks), events(expected.breaks));
      EXPECT_EQ(result.bridge_releases.size(), expected.bridge_releases.size());
      EXPECT_EQ(result.counts.steps, expected.counts.steps);
      EXPECT_EQ(result.outcome, expected.outcome);
      EXPECT_LT(result.energy_error, 1e-4);
      if (parameters.time.start == input::Start::quasi_static) {
        EXPECT_EQ(result.onset_force, expected.onset_force);
      }
    }
  }
}

TEST_F(PetscEngine, HasTheSameBitsOnTheSameNumberOfRanks) {
  auto parameters = test::pulled_bar(torn_bar());
  parameters.fracture.release = input::Release::facet;
  for (const auto& each : {torn_bar(), test::pulled_bar(torn_bar()), parameters}) {
    const auto whole = sample(each);
    const auto again = sample(each);
    const auto pieces = in_pieces(each, false);
    if (!world_.is_root()) continue;
    EXPECT_GT(whole.breaks.size(), 20U) << "the case must break";
    EXPECT_GE(n_suspended_, 2);
    test::expect_same_course(whole, again);
    test::expect_same_course(whole, pieces);
  }
}

TEST_F(PetscEngine, GoesOnOnAnotherNumberOfRanks) {
  for (const auto& each : {torn_bar(), test::pulled_bar(torn_bar())}) {
    const auto whole = sample(each);
    const auto pieces = in_pieces(each, true);
    if (!world_.is_root()) continue;
    std::printf("%d ranks, and one in between: %zu breaks, suspended %d times\n", world_.size(),
                whole.breaks.size(), n_suspended_);
    EXPECT_GE(n_suspended_, 2);
    EXPECT_EQ(events(whole.breaks), events(pieces.breaks));
    EXPECT_EQ(whole.counts.steps, pieces.counts.steps);
    EXPECT_EQ(whole.counts.force_evaluations, pieces.counts.force_evaluations);
    EXPECT_NEAR(whole.energy.back().kinetic, pieces.energy.back().kinetic,
                1e-9 * whole.energy.back().kinetic);
  }
}

TEST_F(PetscEngine, DoesNotGoOnFromTheOtherEngine) {
  for (const auto from : {Engine::fixed_point, Engine::petsc}) {
    auto parameters = torn_bar();
    parameters.time.engine = from;
    std::vector<std::byte> saved;
    int n_looks = 0;
    SampleControl control;
    control.stop = [&] { return ++n_looks > 10; };
    control.save = [&](std::span<const std::byte> bytes) { saved.assign(bytes.begin(), bytes.end()); };
    EXPECT_TRUE(run_sample(world_, parameters, parameters.output, part(world_), control).suspended);
    parameters.time.engine = from == Engine::petsc ? Engine::fixed_point : Engine::petsc;
    std::string lines;
    SampleControl again;
    again.log = [&](const std::string& line) { lines += line + "\n"; };
    again.checkpoint = saved;
    const auto result = run_sample(world_, parameters, parameters.output, part(world_), again);
    const auto expected = sample(parameters);
    if (!world_.is_root()) continue;
    EXPECT_NE(lines.find("the checkpoint is not used: it was made by another engine"), std::string::npos)
        << lines;
    test::expect_same_course(expected, result);
  }
}

TEST_F(PetscEngine, EndsOnAllRanksWhenANumberIsNotFinite) {
  auto parameters = torn_bar();
  parameters.time.step = 1e-8;
  const auto subdomain = part(world_);
  for (const double wrong : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    fracture::BreakableBody body(subdomain, parameters.material());
    const auto loads = mechanics::make_boundary_loads(world_, parameters, subdomain);
    fracture::FractureLaw law(fracture::make_criterion(
        parameters.fracture_of(0), fracture::tetrahedron_strengths(world_, parameters, 0, body).nucleation,
        *parameters.time.step, mechanics::TetrahedronField(parameters.fracture.impulse)));
    const MotionContext context{&world_, &body, &loads, &law};
    const EnergyAccount account(world_, body);
    MotionState state{parallel::NodeField(world_, subdomain.layout),
                      parallel::NodeField(world_, subdomain.layout)};
    const auto motion = make_petsc_motion(context, 0, state);
    EXPECT_FALSE(motion->failure());
    PhaseOptions options;
    options.grid = {*parameters.time.step, 1200};
    options.n_energy_rows = 1;
    options.on_row = [&](const EnergyRow&) {
      if (world_.rank() != world_.size() - 1) return;
      const auto is_free = [](const geometry::Point& p) { return p[2] > 0; };
      const auto free_node = std::ranges::find_if(subdomain.nodes, is_free) - subdomain.nodes.begin();
      state.velocity.owned()[3 * index(free_node)] = wrong;
    };
    std::string message;
    try {
      run_explicit_phase(context, *motion, splitting(input::Integrator::verlet), account, 0, options, state);
    } catch (const NumberRangeExceeded& error) {
      message = error.what();
    }
    EXPECT_TRUE(motion->failure() || world_.rank() != world_.size() - 1);
    EXPECT_THAT(message, testing::HasSubstr("is not finite (0.32 us after the start of the phase)"));
    EXPECT_THAT(message, testing::StartsWith("the displacement of node "));
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
