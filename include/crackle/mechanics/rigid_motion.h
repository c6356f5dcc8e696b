// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/subdomain.h"
#include "crackle/mechanics/boundary_loads.h"
#include "crackle/parallel/communicator.h"

#include <string>
#include <vector>

namespace crackle::mechanics {

/// The rigid motions that the prescribed displacements leave free, such as "turn about x", or "move along x"
/// where the body cannot turn; none where they hold it, as an equilibrium needs. Equal on every rank.
/// Collective.
std::vector<std::string> free_rigid_motions(const parallel::Communicator& group,
                                            const geometry::Subdomain& subdomain, const BoundaryLoads& loads);

}  // namespace crackle::mechanics
