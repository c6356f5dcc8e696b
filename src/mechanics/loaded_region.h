// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/condition_region.h"
#include "geometry/subdomain.h"
#include "input/profile.h"
#include "mechanics/conditions.h"
#include "parallel/communicator.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace crackle::mechanics {

/// The owned nodes in a condition's region, ascending. Local.
std::vector<std::int32_t> nodes_in_region(const geometry::ConditionRegion& region,
                                          const geometry::Subdomain& subdomain);

/// The part of a condition's region on this rank: tributary areas of its owned nodes, times the factor if the
/// condition has one.
struct LoadedRegion {
  std::vector<std::int32_t> nodes;  ///< ascending
  std::vector<double> area;         ///< or lengths of a line, or 1 at a point
  double total_area = 0;            ///< sum of magnitudes over all ranks
  double resultant = 0;             ///< with signs
};

/// The whole region, regardless of direction. Collective.
LoadedRegion loaded_region(const parallel::Communicator& group, const geometry::ConditionRegion& region,
                           const geometry::Subdomain& subdomain,
                           const std::optional<input::Profile>& factor = std::nullopt);

/// The faces of a region, weighted. Collective.
/// @param share of a triangle's area that counts
LoadedRegion loaded_faces(const parallel::Communicator& group, const geometry::ConditionRegion& region,
                          const geometry::Subdomain& subdomain,
                          const std::function<double(const geometry::BoundaryTriangle&)>& share,
                          const std::optional<input::Profile>& factor = std::nullopt);

}  // namespace crackle::mechanics
