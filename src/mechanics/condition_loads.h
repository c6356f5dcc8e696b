// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/condition_region.h"
#include "geometry/subdomain.h"
#include "input/model.h"
#include "mechanics/conditions.h"
#include "parallel/communicator.h"

#include <vector>

namespace crackle::mechanics {

/// A boundary condition of the input on the mesh.
struct ConditionOnMesh {
  const parallel::Communicator& group;
  const geometry::Subdomain& subdomain;
  const MaterialField& material;  ///< of each tetrahedron
  const input::Boundary& condition;
  int number;  ///< index into the input's boundaries
  const geometry::ConditionRegion& region;
  const std::vector<Vector>& outward;  ///< unit normal of every face of the body
};

/// Adds the loads, motions or dashpots of a condition, and its nodes. Collective.
/// @throws parallel::AgreedError when its region contains no part of the mesh
void add_condition(const ConditionOnMesh& place, Conditions& loads);

}  // namespace crackle::mechanics
