// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

namespace crackle::parallel {

/// Source of a ghost's values.
struct GhostSource {
  std::int32_t rank;  ///< owner of the node
  std::int32_t node;  ///< its local number there
};

/// The distribution of a mesh's nodes over the ranks of a group, as seen by one of them. A rank first holds
/// the nodes that it owns, with local numbers from 0, and then its ghosts: copies of nodes owned by others.
struct NodeLayout {
  std::int64_t n_global = 0;
  std::int32_t n_owned = 0;
  std::vector<std::int64_t>
      number;  ///< of each node held, in the mesh; ascending among owned nodes and among ghosts
  std::vector<GhostSource> ghosts;  ///< in the order of their local numbers
  /// Number of nodes owned by lower ranks, for each rank of the group, then the total: owned node i of rank r
  /// is entry first_owned[r] + i of a distributed vector.
  std::vector<std::int64_t> first_owned;

  std::int32_t n_local() const { return static_cast<std::int32_t>(number.size()); }
};

}  // namespace crackle::parallel
