// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/realization.h"

#include <cstdint>
#include <vector>

namespace crackle::geometry {

/// Assignment of tetrahedra and nodes to the ranks of a group.
struct Partition {
  int n_parts = 1;
  std::vector<std::int32_t> tetrahedron_part;
  std::vector<std::int32_t> node_part;  ///< one of the parts that own a tetrahedron around the node
  double imbalance = 1;                 ///< largest number of tetrahedra of a part divided by the mean
};

/// METIS k-way partition of the dual graph (fixed options), with equal weights of all tetrahedra. Results
/// never depend on it; speed does.
///
/// Parts are numbered in the order of their smallest tetrahedron. With more parts than tetrahedra the last
/// parts are empty.
/// @param seed of METIS's random choices
/// @throws std::runtime_error with METIS's error code; std::invalid_argument for n_parts < 1
Partition partition(const Realization& realization, int n_parts, int seed = 1);

/// The partition with the given parts of the tetrahedra; parts may be empty or disconnected. A node goes to
/// the part with the fewest nodes so far among those that own a tetrahedron around it.
Partition partition_of(const Realization& realization, std::vector<std::int32_t> tetrahedron_part,
                       int n_parts);

/// Tetrahedron faces between two parts.
std::int64_t edge_cut(const Realization& realization, const Partition& partition);

}  // namespace crackle::geometry
