// SPDX-License-Identifier: GPL-3.0-or-later
#include "block_factors.h"

#include "common/index.h"

#include <Eigen/LU>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

namespace crackle::mechanics {

namespace {

/// An elimination order that keeps the blocks together.
std::vector<std::int32_t> elimination_order(std::int32_t n_rows,
                                            std::span<const PlacedBlock> lower_triangle) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& placed : lower_triangle) entries.emplace_back(placed.row, placed.column, 1);
  Eigen::SparseMatrix<double> pattern(n_rows, n_rows);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::AMDOrdering<int>::PermutationType order;
  Eigen::AMDOrdering<int>()(Eigen::SparseMatrix<double>(pattern.selfadjointView<Eigen::Lower>()), order);
  const Eigen::AMDOrdering<int>::PermutationType place = order.inverse();
  return {place.indices().data(), place.indices().data() + n_rows};
}

}  // namespace

BlockFactors::BlockFactors(std::int32_t n_rows) : n_rows_(n_rows), permuted_(6 * index(n_rows)) {}

void BlockFactors::factorize(std::span<const PlacedBlock> lower_triangle) {
  place_ = elimination_order(n_rows_, lower_triangle);
  std::vector<std::vector<const PlacedBlock*>> entries(index(n_rows_));  // of each column
  for (const auto& placed : lower_triangle)
    entries[index(std::min(place_[index(placed.row)], place_[index(placed.column)]))].push_back(&placed);

  first_.assign(1, 0);
  row_of_block_.clear();
  block_.clear();
  inverse_diagonal_.clear();
  std::vector<Block> diagonal;                                // D
  std::vector<Block> sums(index(n_rows_));                    // the current column of L D
  std::vector<std::int32_t> rows;                             // of its blocks
  std::vector<std::int32_t> last_column(index(n_rows_), -1);  // with a block in the row
  const auto sum = [&](std::int32_t row, std::int32_t column) -> Block& {
    if (std::exchange(last_column[index(row)], column) != column) {
      sums[index(row)].setZero();
      rows.push_back(row);
    }
    return sums[index(row)];
  };
  // Earlier columns by the row of their next block, and its place.
  std::vector<std::vector<std::array<std::int32_t, 2>>> next_blocks(index(n_rows_));
  const auto wait = [&](std::int32_t column, std::int32_t place) {
    if (place < first_[index(column) + 1])
      next_blocks[index(row_of_block_[index(place)])].push_back({column, place});
  };
  for (std::int32_t column = 0; column < n_rows_; ++column) {
    rows.clear();
    for (const auto* entry : entries[index(column)]) {
      const std::int32_t row = place_[index(entry->row)], other = place_[index(entry->column)];
      if (row >= other)
        sum(row, column) += entry->block;
      else
        sum(other, column) += entry->block.transpose();
    }
    for (const auto [earlier, place] : next_blocks[index(column)]) {
      const Block factor = diagonal[index(earlier)] * block_[index(place)].transpose();
      for (auto b = place; b < first_[index(earlier) + 1]; ++b)
        sum(row_of_block_[index(b)], column).noalias() -= block_[index(b)] * factor;
      wait(earlier, place + 1);
    }
    std::ranges::sort(rows);
    diagonal.emplace_back(sum(column, column).selfadjointView<Eigen::Lower>());
    inverse_diagonal_.emplace_back(diagonal.back().inverse());
    if (!inverse_diagonal_.back().allFinite())
      throw std::runtime_error("static solver: the coarse matrix could not be factorized");
    for (const auto row : rows) {
      if (row == column) continue;
      row_of_block_.push_back(row);
      block_.emplace_back(sums[index(row)] * inverse_diagonal_.back());
    }
    first_.push_back(static_cast<std::int32_t>(block_.size()));
    wait(column, first_[index(column)]);
  }
}

void BlockFactors::solve(std::span<double> numbers) {
  for (std::size_t r = 0; r < place_.size(); ++r)
    std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(6 * r), 6, permuted_.begin() + 6 * place_[r]);
  for (std::int32_t column = 0; column < n_rows_; ++column) {
    const Row x = row(column);
    for (auto b = first_[index(column)]; b < first_[index(column) + 1]; ++b)
      row(row_of_block_[index(b)]).noalias() -= block_[index(b)] * x;
  }
  for (std::int32_t column = n_rows_ - 1; column >= 0; --column) {
    Row x = inverse_diagonal_[index(column)] * row(column);
    for (auto b = first_[index(column)]; b < first_[index(column) + 1]; ++b)
      x.noalias() -= block_[index(b)].transpose() * row(row_of_block_[index(b)]);
    row(column) = x;
  }
  for (std::size_t r = 0; r < place_.size(); ++r)
    std::copy_n(permuted_.begin() + 6 * place_[r], 6, numbers.begin() + static_cast<std::ptrdiff_t>(6 * r));
}

}  // namespace crackle::mechanics
