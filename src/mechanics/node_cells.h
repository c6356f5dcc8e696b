// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/subdomain.h"
#include "crackle/mechanics/edges.h"
#include "crackle/parallel/communicator.h"

#include "kernels/cell_kernels.h"

#include <array>
#include <cstdint>
#include <vector>

namespace crackle::mechanics {

/// Cells of nodes that overlap: a node's shares of the cells around it add up to one.
///
/// They come from halving the body's bounding box until a cell has few nodes; then each node takes the mean
/// of its neighbours' shares, a few times over, and forgets the smallest. So a function that is smooth in
/// every cell is smooth in the body: it does not jump from cell to cell, but does across a notch. Cells and
/// shares are fixed by positions and edges, with the same bits for every partition.
struct NodeCells {
  static constexpr std::int32_t whole = 64;
  /// Ascending cells; those behind the last have no weight.
  struct Shares {
    std::array<std::int32_t, kernels::n_shares> cell{};
    std::array<std::int32_t, kernels::n_shares> weight{};  ///< parts of `whole`
  };

  std::vector<geometry::Point> centre;  ///< of each cell
  std::vector<double> extent;           ///< the longest side of the box round the nodes it began with
  std::vector<Shares> shares;           ///< of each local node
  geometry::Box box;                    ///< round the body

  std::int32_t size() const { return static_cast<std::int32_t>(centre.size()); }
};
/// The box round all nodes of the body. Collective; agrees before its messages.
geometry::Box box_of_all(const parallel::Communicator& group, const geometry::Subdomain& subdomain);
/// Collective; agrees before its messages.
NodeCells make_node_cells(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                          const Edges& edges);

}  // namespace crackle::mechanics
