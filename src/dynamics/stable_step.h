// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/mass_scaling.h"
#include "geometry/realization.h"
#include "geometry/subdomain.h"
#include "input/model.h"
#include "mechanics/internal_force.h"
#include "mechanics/node_stiffness.h"
#include "mechanics/operators.h"
#include "parallel/communicator.h"

#include <cstdint>
#include <optional>
#include <span>

namespace crackle::dynamics {

/// Largest circular eigenfrequency of M^-1 K of the unconstrained body, by the Lanczos method on the force
/// itself; the residual of the estimate is added, so that the result is an upper bound in practice.
/// Constraints only lower it. Collective; bitwise equal for any number of ranks. [1/s]
double largest_frequency(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                         const mechanics::PdsOperators& operators, const mechanics::InternalForce& force);

/// Largest stable time step of an integrator on the intact body, with its bulk viscosity and springs [s].
/// Collective, as above.
double stable_step(const parallel::Communicator& group, input::Integrator integrator,
                   const input::BulkViscosity& bulk, const geometry::Subdomain& subdomain,
                   const mechanics::PdsOperators& operators, const mechanics::MaterialField& material,
                   const mechanics::InternalForce& force,
                   std::span<const mechanics::NodeStiffness> springs = {});

/// The same on a realization, with the input's mass scaling.
struct StableStep {
  double step;  ///< [s]
  std::optional<MassScaling> mass_scaling;
};

/// Not collective (runs on one rank).
StableStep stable_step(const input::Model& model, const geometry::Realization& realization);

/// The time step of a run and its number of steps.
struct TimeGrid {
  double step;           ///< [s]
  std::int64_t n_steps;  ///< a whole number of the integrator's cycles, covering the duration

  double duration() const { return static_cast<double>(n_steps) * step; }  ///< [s]
};

/// The input's step or, with "auto", the largest step that divides the duration and is below 0.9 of the
/// stable one.
/// @throws std::runtime_error naming the stable step when the input's step exceeds it
TimeGrid choose_time_grid(const input::Time& time, double stable_step);

}  // namespace crackle::dynamics
