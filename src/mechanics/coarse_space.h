// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/subdomain.h"
#include "mechanics/edges.h"
#include "mechanics/elasticity.h"
#include "mechanics/node_stiffness.h"
#include "mechanics/operators.h"
#include "mechanics/residual_stiffness.h"
#include "parallel/communicator.h"

#include "block_factors.h"
#include "kernels/cell_kernels.h"
#include "node_cells.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::mechanics {

/// The coarse problem of the static solver: rigid motions of cells of nodes, blended where cells overlap.
///
/// All sums are over integers, so the correction is bitwise equal for every partition. Every rank holds and
/// factorizes the whole coarse matrix.
class CoarseSpace {
public:
  /// Collective. The references must outlive the object.
  /// @param constrained 1 for each displacement component that is prescribed, 3 n_local
  CoarseSpace(const parallel::Communicator& group, const geometry::Subdomain& subdomain, const Edges& edges,
              std::span<const std::uint8_t> constrained);

  /// Assembles and factorizes the coarse matrix A of the current stiffness. Collective.
  /// @param springs that hold owned nodes besides
  void factorize(const PdsOperators& operators, const ElasticityField& elasticity,
                 const ResidualStiffness& residual_stiffness, std::span<const NodeStiffness> springs = {});

  /// result = B residual + R A^-1 R^T residual, with R the displacements of the nodes in the cells' motions.
  /// Collective; does not allocate.
  /// @param residual 3 n_owned, 0 at constrained components
  /// @param block B of the owned node at each position
  /// @param result 3 n_owned, ignoring constraints
  /// @return an upper bound on this rank's products of a residual and its result
  double precondition(std::span<const float> residual, std::span<const std::array<float, 6>> block,
                      std::span<float> result);

  /// Index of an owned node in the order of the cells.
  std::size_t position(std::int32_t owned_node) const { return index(position_[index(owned_node)]); }

  std::int32_t n_cells() const { return cells_.size(); }

private:
  void order_nodes();
  template <class BlockSums>
  void add_spring(const NodeStiffness& spring, double scale, BlockSums& sums) const;
  kernels::NodesInCells nodes() const { return {groups_.data(), groups_.size(), nodes_.data()}; }
  void find_motions(std::span<const float> residual);

  const parallel::Communicator* group_;
  const geometry::Subdomain* subdomain_;
  std::span<const std::uint8_t> constrained_;
  const kernels::CellKernels* kernels_;
  NodeCells cells_;
  std::vector<kernels::CellGroup> groups_;
  std::vector<kernels::NodeInCells>
      nodes_;  // owned; positions relative to the centre of the body, in units of half its length
  std::vector<std::int32_t> position_;  // of each owned node in `nodes_`
  std::vector<Vector> centre_;          // of each cell, likewise
  std::vector<double> magnification_;   // of each cell: half the body's length over the cell's
  int digits_ = 0;                      // of the summed integers
  // Per cell: first the loads during summation, then the motions, as translation at the centre of the body
  // and rotation.
  std::vector<kernels::CellNumbers> numbers_;
  std::vector<double> packed_;  // the same without padding
  double largest_load_ = 0;     // of all ranks
  BlockFactors factors_;
};

}  // namespace crackle::mechanics
