// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/subdomain.h"
#include "mechanics/operators.h"
#include "parallel/communicator.h"

#include <vector>

namespace crackle::dynamics {

/// The share of the body's surface of each owned node: a third of each boundary triangle around it, 0 inside
/// the body [m^2]. Local; bitwise equal for any number of ranks.
std::vector<double> surface_areas(const geometry::Subdomain& subdomain);

/// Pressure by which surfaces resist overlap, per depth, the same everywhere [Pa/m]: the largest with which
/// no surface node alone oscillates faster than sqrt(share) omega_max against a rigid surface. The stable
/// step of the body is then shortened by 1 / sqrt(1 + share) at most. Collective; bitwise equal for any
/// number of ranks.
/// @param omega_max largest circular frequency of the body alone, as of largest_frequency() [1/s]
double contact_stiffness(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                         const mechanics::PdsOperators& operators, double omega_max, double share);

}  // namespace crackle::dynamics
