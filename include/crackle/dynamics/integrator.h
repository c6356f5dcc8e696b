// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"

#include <span>

namespace crackle::dynamics {

/// One stage of a splitting step: a momentum update by the force ("kick") or a displacement update by the
/// velocity ("drift").
struct Stage {
  enum class Kind { kick, drift } kind;
  double fraction;  ///< of the time step
};

/// A symplectic integrator: the stages of its even and odd steps.
struct Splitting {
  std::span<const Stage> even;
  std::span<const Stage> odd;
  double stability_limit;  ///< largest stable omega_max dt
  int steps_per_cycle;     ///< a run is a whole number of cycles
  double forces_per_step;  ///< force evaluations per step, counting those shared by adjacent stages once
};

/// bilateral4: the fourth-order map of McLachlan and Atela (1992) alternating with its adjoint (Casetti
/// 1995), stable up to the pair's unstable pocket at omega dt = 1.570. verlet: kick-drift-kick of order 2,
/// stable below 2.
const Splitting& splitting(input::Integrator integrator);

}  // namespace crackle::dynamics
