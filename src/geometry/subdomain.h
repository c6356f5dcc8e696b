// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/partition.h"
#include "geometry/realization.h"
#include "parallel/node_layout.h"

#include <cstdint>
#include <vector>

namespace crackle::geometry {

/// The part of a realization computed by one rank of a group: every tetrahedron that touches an owned node,
/// and those of a halo.
///
/// A tetrahedron on a part boundary is held and computed by every rank that owns one of its nodes. Thus all
/// contributions to an owned node are on its own rank, in ascending global order, and a force evaluation
/// needs a single exchange of ghost values.
struct Subdomain {
  std::int64_t n_tetrahedra_global = 0;
  parallel::NodeLayout layout;
  std::vector<Point> nodes;             ///< of the layout, ghosts included [m]
  std::vector<Tetrahedron> tetrahedra;  ///< local node numbers, in ascending order of tetrahedron_number
  std::vector<std::int64_t> tetrahedron_number;  ///< in the realization
  std::vector<std::uint8_t>
      owned;  ///< 1 on exactly one rank for each tetrahedron: the rank that includes it in sums
  std::vector<BoundaryTriangle> boundary;  ///< local node numbers; every triangle that touches an owned node
  std::vector<std::int64_t> boundary_number;  ///< in the realization, ascending
  std::vector<std::uint8_t> material = {};    ///< per tetrahedron, as in the realization
  std::vector<std::uint8_t> interface = {};   ///< likewise
  std::vector<float> map_factor = {};         ///< likewise
  std::vector<std::int32_t> pre_crack = {};   ///< likewise
  std::vector<Vector> pre_crack_normal = {};  ///< of all pre-cracks of the realization

  /// Local number of a tetrahedron of the realization, or -1.
  std::int32_t local_number(std::int64_t tetrahedron) const;
  /// Number of a tetrahedron's material and interface together.
  std::int32_t kind(std::int32_t tetrahedron) const {
    const auto number = [&](const std::vector<std::uint8_t>& of) {
      return of.empty() ? 0 : static_cast<std::int32_t>(of[static_cast<std::size_t>(tetrahedron)]);
    };
    return 256 * number(material) + number(interface);
  }
  std::int32_t n_local() const { return static_cast<std::int32_t>(nodes.size()); }
  std::int32_t n_tetrahedra() const { return static_cast<std::int32_t>(tetrahedra.size()); }
};

/// All parts of a realization, one per rank of the group; one that owns no nodes is empty.
/// @param halo each part also has all tetrahedra whose centroid is closer than this to that of one that it
///   owns [m]
std::vector<Subdomain> split(const Realization& realization, const Partition& partition, double halo = 0);

}  // namespace crackle::geometry
