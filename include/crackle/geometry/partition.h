// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/realization.h"

#include <cstdint>
#include <vector>

namespace crackle::geometry {

/// Assignment of tetrahedra and nodes to the ranks of a group.
struct Partition {
  int n_parts = 1;
  std::vector<std::int32_t> tetrahedron_part;
  std::vector<std::int32_t> node_part;  ///< a part that owns a tetrahedron round the node
  std::int64_t edge_cut = 0;            ///< tetrahedron faces between two parts
  double imbalance = 1;                 ///< largest part over the mean
};

/// METIS k-way partition of the dual graph (fixed seed and options). Results never depend on it; speed does.
Partition partition(const Realization& realization, int n_parts);

}  // namespace crackle::geometry
