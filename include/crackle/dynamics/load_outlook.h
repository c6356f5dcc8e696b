// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"
#include "crackle/dynamics/energy_account.h"
#include "crackle/dynamics/quasi_static.h"
#include "crackle/geometry/realization.h"
#include "crackle/input/parameters.h"

#include <string>

namespace crackle::dynamics {

/// How far the loads go towards the first break, in equilibria.
struct LoadOutlook {
  bool breaks = true;      ///< whether they break the body
  bool grows = false;      ///< where they do not: whether they go on to rise without end
  double time = infinity;  ///< of the first break, from the start of loading on; infinite without one [s]
  double load = 0;         ///< of the machine at the first break, or the largest without one [N]
  double share = 1;        ///< without a break: the largest stress over the strength at its place
};

/// Loads a body that nothing has broken yet up to its first break, and through the equilibrium after it.
/// Collective.
LoadOutlook first_break(QuasiStaticLoading& loading, const mechanics::BoundaryLoads& loads,
                        EnergyAccount& account);

/// The same for a realization of its own, whatever the start; of a body that nothing holds, as if the loads
/// broke it. Not collective (runs on one rank).
/// @throws std::runtime_error when there is no equilibrium
LoadOutlook static_outlook(const input::Parameters& parameters, const geometry::Realization& realization);

/// That the loads of the input break nothing, by how much they miss it, and what to change; empty where they
/// break the body. With start = "rest" only a clear miss counts, since waves may add up.
std::string weak_load_warning(const input::Parameters& parameters, const LoadOutlook& outlook);

}  // namespace crackle::dynamics
