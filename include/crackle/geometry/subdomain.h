// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/partition.h"
#include "crackle/geometry/realization.h"
#include "crackle/parallel/node_layout.h"

#include <cstdint>
#include <vector>

namespace crackle::geometry {

/// The part of a realization that one rank of a group computes: every tetrahedron that touches a node it
/// owns, and those of a halo.
///
/// A tetrahedron on a part boundary is held, and computed, by every rank that owns one of its nodes; so an
/// owned node finds all its contributions on its own rank, always in ascending global order, and one exchange
/// of the ghost nodes' values is all that a force evaluation needs.
struct Subdomain {
  std::int64_t n_tetrahedra_global = 0;
  parallel::NodeLayout layout;
  std::vector<Point> nodes;             ///< of the layout, ghosts included [m]
  std::vector<Tetrahedron> tetrahedra;  ///< local node numbers, in ascending order of tetrahedron_number
  std::vector<std::int64_t> tetrahedron_number;  ///< in the realization
  std::vector<std::uint8_t> counted;  ///< 1 on exactly one rank for each tetrahedron: where sums count it
  std::vector<BoundaryTriangle> boundary;  ///< local node numbers; every triangle that touches an owned node
  std::vector<std::int64_t> boundary_number;  ///< in the realization, ascending

  /// Local number of a tetrahedron of the realization, or -1.
  std::int32_t local_number(std::int64_t tetrahedron) const;
  std::int32_t n_local() const { return static_cast<std::int32_t>(nodes.size()); }
  std::int32_t n_tetrahedra() const { return static_cast<std::int32_t>(tetrahedra.size()); }
};

/// All parts of a realization, one for each rank of the group; one that owns no nodes is empty.
/// @param halo each part also has all tetrahedra whose centroid is nearer than this to that of one that it
///   counts [m]
std::vector<Subdomain> split(const Realization& realization, const Partition& partition, double halo = 0);

}  // namespace crackle::geometry
