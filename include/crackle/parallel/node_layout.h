// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

namespace crackle::parallel {

/// Where a ghost's values come from.
struct GhostSource {
  std::int32_t rank;  ///< that owns the node
  std::int32_t node;  ///< its local number there
};

/// How the nodes of a mesh are shared out among the ranks of a group, as one of them sees it. A rank holds
/// the nodes that it owns, with local numbers from 0 on, and then its ghosts: copies of nodes that others
/// own.
struct NodeLayout {
  std::int64_t n_global = 0;
  std::int32_t n_owned = 0;
  std::vector<std::int64_t>
      number;  ///< of each node held, in the mesh; ascending among owned and among ghosts
  std::vector<GhostSource> ghosts;  ///< in the order of their local numbers
  /// Nodes that lower ranks own, for each rank of the group, and then all: owned node i of rank r is number
  /// first_owned[r] + i of a vector that is distributed over the ranks.
  std::vector<std::int64_t> first_owned;

  std::int32_t n_local() const { return static_cast<std::int32_t>(number.size()); }
};

}  // namespace crackle::parallel
