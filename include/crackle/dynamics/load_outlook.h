// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"
#include "crackle/dynamics/energy_account.h"
#include "crackle/dynamics/quasi_static.h"
#include "crackle/geometry/realization.h"
#include "crackle/input/parameters.h"

#include <span>
#include <string>

namespace crackle::dynamics {

/// Extremes of the stress in a body, and its energy.
struct StressState {
  double tension = 0;      ///< largest principal stress [Pa]
  double compression = 0;  ///< largest pressure along a principal axis [Pa]
  double energy = 0;       ///< [J]
};

/// Collective. @param displacement 3 n_local
StressState stress_state(const parallel::Communicator& group, const fracture::BreakableBody& body,
                         std::span<const double> displacement);

/// Static prediction of the first break under the loads.
struct LoadOutlook {
  bool breaks = true;      ///< the loads break the body
  bool grows = false;      ///< without a break: the loads grow without bound
  double time = infinity;  ///< of the first break, from the start of loading; infinite without one [s]
  double load = 0;         ///< of the machine at the first break, or its maximum without one [N]
  double transit = 0;      ///< of a wave along the body, see wave_transit; 0: not known [s]
  double share = 1;        ///< without a break: the largest ratio of stress to strength
};

/// Loads an unbroken body up to its first break and through the equilibrium after it. Collective.
LoadOutlook first_break(QuasiStaticLoading& loading, const mechanics::BoundaryLoads& loads,
                        EnergyAccount& account);

/// The same for a realization, for any `start`; an unsupported body, and one at rest that is struck so fast
/// that the wave may break it, are taken to break. Not collective (runs on one rank).
/// @throws std::runtime_error when there is no equilibrium
LoadOutlook static_outlook(const input::Parameters& parameters, const geometry::Realization& realization);

/// Warning that the loads of the input do not break the body, with the margin and advice; empty if they do.
/// With start = "rest" only a large margin counts, since waves may superpose.
std::string weak_load_warning(const input::Parameters& parameters, const LoadOutlook& outlook);

}  // namespace crackle::dynamics
