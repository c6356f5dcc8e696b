// SPDX-License-Identifier: GPL-3.0-or-later
// A failure on one rank in the middle of a step soon ends the phase on all ranks of the group, with the same
// message.
#include "common/index.h"
#include "dynamics/explicit_phase.h"
#include "fracture/toughness.h"
#include "parallel/agreement.h"

#include "support/box_mesh.h"
#include "support/group.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <tuple>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

enum class Place { stages, check, strain, release };

/// A motion that fails at one step on one rank.
class FailingMotion final : public MovingBody {
public:
  FailingMotion(MovingBody& motion, Place place, std::int64_t step)
      : motion_(&motion), place_(place), failing_step_(step) {}

  void step(std::span<const Stage> stages, double time_step, double time) override {
    motion_->step(stages, time_step, time);
    ++n_steps_;
    fail_at(Place::stages);
  }
  std::span<const std::int32_t> overloaded() override {
    fail_at(Place::check);
    return motion_->overloaded();
  }
  mechanics::Symmetric strain(std::int32_t tetrahedron) const override {
    fail_at(Place::strain);
    return motion_->strain(tetrahedron);
  }
  mechanics::Symmetric strain_before(std::int32_t tetrahedron, int n_steps) const override {
    return motion_->strain_before(tetrahedron, n_steps);
  }
  void relative_displacements(std::span<const std::int32_t> nodes, int n_steps,
                              std::span<Vector> result) const override {
    fail_at(Place::strain);
    motion_->relative_displacements(nodes, n_steps, result);
  }
  void release(std::span<const std::int32_t> tetrahedra) override {
    fail_at(Place::release);
    motion_->release(tetrahedra);
  }
  void read(MotionState& state) const override { motion_->read(state); }
  double strain_energy(const MotionState& state) const override { return motion_->strain_energy(state); }
  double external_work(double time, const MotionState& state) const override {
    return motion_->external_work(time, state);
  }
  void end_loads(double time, const mechanics::NodesOfConditions& nodes, const MotionState& state) override {
    motion_->end_loads(time, nodes, state);
  }
  std::optional<std::string> failure() const override { return motion_->failure(); }
  MotionCheckpoint save() const override { return motion_->save(); }
  void restore(const MotionCheckpoint& checkpoint) override { motion_->restore(checkpoint); }
  std::int64_t n_forces() const override { return motion_->n_forces(); }

  std::int64_t n_steps() const { return n_steps_; }

private:
  void fail_at(Place place) const {
    if (place == place_ && n_steps_ >= failing_step_)
      throw std::runtime_error("the disk of rank r is on fire");
  }

  MovingBody* motion_;
  Place place_;
  std::int64_t failing_step_;
  std::int64_t n_steps_ = 0;
};

class FailingRank : public testing::TestWithParam<std::tuple<input::Release, input::Engine>> {};

TEST_P(FailingRank, EndsThePhaseOnAllRanks) {
  const parallel::Communicator world(test::group());
  auto parameters = test::brittle({0.002, 0.004, 0.012});
  std::tie(parameters.fracture.release, parameters.time.engine) = GetParam();
  parameters.time.precision = input::Precision::double_;
  parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}));
  parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::traction, {}, {0, 3e6, 22e6}));
  const auto mesh =
      test::make_box({.size = parameters.specimen.size, .cells = {3, 5, 14}, .disturbance = 0.2});
  const auto part = geometry::split(mesh, geometry::partition(mesh, world.size()))[index(world.rank())];
  constexpr std::int64_t failing_step = 200;

  for (const Place place : {Place::stages, Place::check, Place::strain, Place::release}) {
    fracture::BreakableBody body(part, parameters.material(), fracture::make_release(parameters.fracture));
    const auto loads = mechanics::make_boundary_loads(world, parameters, part);
    fracture::FractureLaw law(fracture::make_criterion(
        parameters.fracture_of(0), fracture::tetrahedron_strengths(world, parameters, 0, body).nucleation,
        5e-9, mechanics::TetrahedronField(parameters.fracture.impulse)));
    const MotionContext context{&world, &body, &loads, &law};
    const EnergyAccount account(world, body);
    MotionState state{parallel::NodeField(world, part.layout), parallel::NodeField(world, part.layout)};
    const auto motion = make_motion(context, parameters.time, 0, 5e-5, state);
    const bool fails = world.rank() == world.size() - 1;
    FailingMotion failing(*motion, place, fails ? failing_step : std::int64_t{1} << 60);
    PhaseOptions options;
    options.grid = {2e-8, 2500};
    std::string message;
    try {
      run_explicit_phase(context, failing, splitting(input::Integrator::bilateral4), account, 0, options,
                         state);
    } catch (const parallel::AgreedError& error) {
      message = error.what();
      EXPECT_EQ(error.failing_rank(), world.size() - 1);
    }
    EXPECT_EQ(message, "time steps: the disk of rank r is on fire") << "at place " << static_cast<int>(place);
    // All ranks have done the same steps, and few more.
    std::int64_t least = failing.n_steps(), most = failing.n_steps();
    MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_INT64_T, MPI_MIN, world.get());
    MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT64_T, MPI_MAX, world.get());
    EXPECT_EQ(least, most);
    if (place == Place::stages || place == Place::check) {
      EXPECT_LE(most, failing_step + steps_per_poll);
    }
    if (world.is_root())
      std::printf("place %d: failed in step %lld or at the next break, ended after step %lld\n",
                  static_cast<int>(place), static_cast<long long>(failing_step),
                  static_cast<long long>(most));
  }
}

std::string case_name(const testing::TestParamInfo<FailingRank::ParamType>& info) {
  const auto& [release, engine] = info.param;
  return std::string(release == input::Release::element ? "Element" : "Facet") +
         (engine == input::Engine::petsc ? "Petsc" : "FixedPoint");
}

INSTANTIATE_TEST_SUITE_P(Releases, FailingRank,
                         testing::Combine(testing::Values(input::Release::element, input::Release::facet),
                                          testing::Values(input::Engine::fixed_point, input::Engine::petsc)),
                         case_name);

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
