// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/subdomain.h"
#include "crackle/mechanics/elasticity.h"
#include "crackle/mechanics/operators.h"
#include "crackle/mechanics/residual_stiffness.h"
#include "crackle/parallel/communicator.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace crackle::mechanics {

/// A coarse problem for the static solver: the rigid motions of cells of nodes.
///
/// The cells come from halving the body's bounding box until a cell has few nodes: they are fixed by
/// position, not by rank. All sums are sums of integers, so the correction has the same bits for every
/// partition. Every rank holds and factorizes the whole coarse matrix.
class CoarseSpace {
public:
  /// Collective.
  /// @param held 1 for each displacement component that is prescribed, 3 n_local
  CoarseSpace(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
              std::span<const std::uint8_t> held);
  ~CoarseSpace();

  /// The coarse matrix of what the tetrahedra carry, and its factors. Collective.
  void factorize(const PdsOperators& operators, const IsotropicElasticity& elasticity,
                 const ResidualStiffness& residual_stiffness);

  /// correction += R^T A^-1 R residual, with R the rigid motions of the cells. Collective.
  /// @param residual, correction 3 n_owned
  void add_correction(std::span<const double> residual, std::span<double> correction) const;

  std::int32_t n_cells() const { return n_cells_; }

private:
  struct Factors;

  void find_cells();
  /// Component `i` of node `n` in the six rigid motions of its cell.
  double rigid(std::size_t n, std::size_t i, std::size_t motion) const;

  const parallel::Communicator* group_;
  const geometry::Subdomain* subdomain_;
  std::span<const std::uint8_t> held_;
  std::int32_t n_cells_ = 0;
  std::vector<std::int32_t> cell_;          // of each local node
  std::vector<std::array<double, 3>> arm_;  // from the cell's centre, over the cell's size
  std::unique_ptr<Factors> factors_;
};

}  // namespace crackle::mechanics
