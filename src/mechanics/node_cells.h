// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/subdomain.h"
#include "kernels/cell_kernels.h"
#include "mechanics/edges.h"
#include "parallel/communicator.h"

#include <array>
#include <cstdint>
#include <vector>

namespace crackle::mechanics {

/// Overlapping cells of nodes: a node's shares in the cells around it add up to one.
///
/// The body's bounding box is bisected until each cell has few nodes; then the shares are smoothed by
/// averaging over neighbours several times, dropping the smallest. Thus a function that is smooth in every
/// cell is smooth in the body, without jumps between cells but with jumps across a notch. Cells and shares
/// depend on positions and edges only, and are bitwise equal for every partition.
struct NodeCells {
  static constexpr std::int32_t whole = 64;
  /// Cells in ascending order; unused entries have zero weight.
  struct Shares {
    std::array<std::int32_t, kernels::n_shares> cell{};
    std::array<std::int32_t, kernels::n_shares> weight{};  ///< parts of `whole`
  };

  std::vector<geometry::Point> centre;  ///< of each cell
  std::vector<double> extent;           ///< longest side of the bounding box of the initial nodes
  std::vector<Shares> shares;           ///< of each local node
  geometry::Box box;                    ///< bounding box of the body

  std::int32_t size() const { return static_cast<std::int32_t>(centre.size()); }
};
/// The bounding box of all nodes of the body. Collective; agrees before its messages.
geometry::Box box_of_all(const parallel::Communicator& group, const geometry::Subdomain& subdomain);
/// Collective; agrees before its messages.
NodeCells make_node_cells(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                          const Edges& edges);

}  // namespace crackle::mechanics
