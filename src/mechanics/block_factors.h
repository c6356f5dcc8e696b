// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::mechanics {

using Block = Eigen::Matrix<double, 6, 6>;
/// A block of the lower triangle of a symmetric matrix.
struct PlacedBlock {
  std::int32_t row = 0, column = 0;  ///< column <= row
  Block block = Block::Zero();
};

/// The L D L^T factorization of a sparse symmetric matrix of 6 x 6 blocks, by block: several times faster
/// than Eigen's, which works number by number. Libraries that work by block call a BLAS, whose bits depend on
/// the machine.
class BlockFactors {
public:
  explicit BlockFactors(std::int32_t n_rows);

  /// @throws std::runtime_error for a matrix without such a factorization
  void factorize(std::span<const PlacedBlock> lower_triangle);

  /// In place: six numbers per row of blocks, right-hand side on entry, solution on return. Does not
  /// allocate.
  void solve(std::span<double> numbers);

private:
  using Row = Eigen::Matrix<double, 6, 1>;
  Eigen::Map<Row> row(std::int32_t i) { return Eigen::Map<Row>(permuted_.data() + 6 * i); }

  std::int32_t n_rows_;
  std::vector<std::int32_t> place_;  // of each row in the elimination order
  std::vector<std::int32_t> first_;  // per column, its first block below the diagonal
  std::vector<std::int32_t> row_of_block_;
  std::vector<Block> block_;             // of L below the diagonal, on which L is the identity
  std::vector<Block> inverse_diagonal_;  // of D
  std::vector<double> permuted_;
};

}  // namespace crackle::mechanics
