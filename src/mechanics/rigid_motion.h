// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/subdomain.h"
#include "mechanics/conditions.h"
#include "parallel/communicator.h"

#include <string>
#include <vector>

namespace crackle::mechanics {

/// The rigid-body motions left free by the prescribed displacements, such as "turn about x", or "move along
/// x" if the body cannot turn; empty if the body is constrained, as an equilibrium requires. Equal on every
/// rank. Collective.
std::vector<std::string> free_rigid_motions(const parallel::Communicator& group,
                                            const geometry::Subdomain& subdomain, const Conditions& loads);

}  // namespace crackle::mechanics
