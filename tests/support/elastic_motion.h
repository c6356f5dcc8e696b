// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/energy_account.h"
#include "dynamics/moving_body.h"
#include "dynamics/stable_step.h"

#include "support/box_mesh.h"
#include "support/job.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace crackle::test {

/// The mesh of a sample of a body without notches, as made by the program.
inline geometry::Realization irregular_box(const geometry::Point& size, double spacing,
                                           std::uint64_t sample = 0) {
  input::Parameters parameters;
  parameters.seed = 1;
  parameters.specimen.size = size;
  parameters.mesh = {.spacing = spacing,
                     .notch_spacing = spacing,
                     .growth = 0.03,
                     .perturbation = 0.2,
                     .min_quality = 0.2,
                     .points = {},
                     .points_digest = {},
                     .regions = {}};
  return realization(parameters, sample);
}

/// Motion of an unbreakable body in fixed-point numbers of 64 bits on one rank.
class ElasticMotion {
public:
  /// @param parameters only their material, damping, mass scaling and boundary list are used
  ElasticMotion(const geometry::Realization& mesh, const input::Parameters& parameters,
                input::Integrator integrator = input::Integrator::bilateral4)
      : damping_rate_(parameters.damping_rate()),
        bulk_viscosity_(parameters.bulk_viscosity()),
        subdomain_(whole(mesh)),
        body_(subdomain_, parameters.material()),
        loads_(mechanics::make_boundary_loads(self_, parameters, subdomain_)),
        law_(unbreakable(subdomain_)),
        state_{parallel::NodeField(self_, subdomain_.layout), parallel::NodeField(self_, subdomain_.layout)},
        map_(dynamics::splitting(integrator)),
        mass_scaling_(dynamics::scale_masses(self_, parameters, subdomain_, body_.operators(),
                                             body_.material(), body_.force())),
        stable_step_(dynamics::stable_step(self_, integrator, bulk_viscosity_, subdomain_, body_.operators(),
                                           body_.material(), body_.force())) {}

  /// Starts at the current state(); the motion lasts at most `duration` [s].
  void start(double duration) {
    dynamics::MotionContext context{&self_, &body_, &loads_, &law_, damping_rate_};
    context.bulk_viscosity = bulk_viscosity_;
    motion_ = dynamics::make_fixed_point_motion(context, input::Precision::double_, 0, duration, state_);
  }
  void advance(std::int64_t n_steps, double step) {
    for (std::int64_t i = 0; i < n_steps; ++i, ++n_steps_done_)
      motion_->step(n_steps_done_ % 2 == 0 ? map_.even : map_.odd, step,
                    static_cast<double>(n_steps_done_) * step);
    motion_->read(state_);
    ASSERT_FALSE(motion_->failure());
  }

  const parallel::Communicator& self() const { return self_; }
  const geometry::Subdomain& subdomain() const { return subdomain_; }
  const fracture::BreakableBody& body() const { return body_; }
  const mechanics::Conditions& loads() const { return loads_; }
  std::size_t n_nodes() const { return subdomain_.nodes.size(); }
  double mass(std::size_t node) const { return body_.operators().node_mass[node]; }
  double displacement(std::size_t node, std::size_t axis) const {
    return state_.displacement.owned()[3 * node + axis];
  }
  double velocity(std::size_t node, std::size_t axis) const {
    return state_.velocity.owned()[3 * node + axis];
  }
  dynamics::MotionState& state() { return state_; }
  /// [J]
  double energy() const {
    double kinetic = 0;
    for (std::size_t n = 0; n < n_nodes(); ++n)
      for (std::size_t i = 0; i < 3; ++i) kinetic += 0.5 * mass(n) * velocity(n, i) * velocity(n, i);
    return kinetic + dynamics::strain_energy(self_, body_, state_.displacement.local());
  }
  double dissipated_energy() const { return motion_->dissipated_energy(); }
  double stable_step() const { return stable_step_; }
  const std::optional<dynamics::MassScaling>& mass_scaling() const { return mass_scaling_; }

private:
  double damping_rate_;
  input::BulkViscosity bulk_viscosity_;
  parallel::Communicator self_{MPI_COMM_SELF};
  geometry::Subdomain subdomain_;
  fracture::BreakableBody body_;
  mechanics::Conditions loads_;
  fracture::FractureLaw law_;
  dynamics::MotionState state_;
  const dynamics::Splitting& map_;
  std::optional<dynamics::MassScaling> mass_scaling_;
  double stable_step_;
  std::unique_ptr<dynamics::MovingBody> motion_;
  std::int64_t n_steps_done_ = 0;
};

}  // namespace crackle::test
