// SPDX-License-Identifier: GPL-3.0-or-later
#include "block_factors.h"

#include "crackle/common/index.h"

#include <Eigen/LU>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include <algorithm>
#include <stdexcept>

namespace crackle::mechanics {

namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;

SparseMatrix assemble(Eigen::Index size, const Triplets& entries) {
  SparseMatrix matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// An elimination order that keeps the blocks together.
std::vector<std::int32_t> elimination_order(std::int32_t n_rows,
                                            std::span<const PlacedBlock> lower_triangle) {
  Triplets entries;
  for (const auto& placed : lower_triangle) entries.emplace_back(placed.row, placed.column, 1);
  Eigen::AMDOrdering<int>::PermutationType order;
  Eigen::AMDOrdering<int>()(SparseMatrix(assemble(n_rows, entries).selfadjointView<Eigen::Lower>()), order);
  const Eigen::AMDOrdering<int>::PermutationType place = order.inverse();
  return {place.indices().data(), place.indices().data() + n_rows};
}

}  // namespace

BlockFactors::BlockFactors(std::int32_t n_rows) : n_rows_(n_rows), permuted_(6 * index(n_rows)) {}

void BlockFactors::factorize(std::span<const PlacedBlock> lower_triangle) {
  place_ = elimination_order(n_rows_, lower_triangle);
  Triplets entries;
  for (const auto& placed : lower_triangle) {
    const std::int32_t row = place_[index(placed.row)], column = place_[index(placed.column)];
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        // Each pair of entries once: a diagonal block holds both.
        if (row == column && j > i) continue;
        const bool is_below = row > column || (row == column && i >= j);
        const int m = 6 * row + i, n = 6 * column + j;
        entries.emplace_back(is_below ? m : n, is_below ? n : m, placed.block(i, j));
      }
    }
  }
  const Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>> solver(
      assemble(6 * n_rows_, entries));
  if (solver.info() != Eigen::Success)
    throw std::runtime_error("static solver: the coarse matrix could not be factorized");

  const SparseMatrix lower = solver.matrixL();
  const auto diagonal = solver.vectorD();
  first_.assign(1, 0);
  row_of_block_.clear();
  block_.clear();
  inverse_diagonal_.clear();
  for (std::int32_t column = 0; column < n_rows_; ++column) {
    Block on_diagonal = Block::Identity();
    const auto first = block_.size();
    for (int j = 0; j < 6; ++j) {
      for (SparseMatrix::InnerIterator entry(lower, 6 * column + j); entry; ++entry) {
        const auto row = static_cast<std::int32_t>(entry.row() / 6);
        const auto i = entry.row() % 6;
        if (row == column) {
          on_diagonal(i, j) = entry.value();
          continue;
        }
        const auto known = std::span(row_of_block_).subspan(first);
        const auto place = first + index(std::ranges::lower_bound(known, row) - known.begin());
        if (place == block_.size() || row_of_block_[place] != row) {
          row_of_block_.insert(row_of_block_.begin() + static_cast<std::ptrdiff_t>(place), row);
          block_.insert(block_.begin() + static_cast<std::ptrdiff_t>(place), Block::Zero());
        }
        block_[place](i, j) = entry.value();
      }
    }
    // Scales L to identity diagonal blocks and moves the scaling into D.
    const Block inverse = on_diagonal.inverse();
    for (std::size_t b = first; b < block_.size(); ++b) block_[b] = (block_[b] * inverse).eval();
    const auto own = diagonal.segment<6>(6 * column);
    inverse_diagonal_.push_back(inverse.transpose() * own.cwiseInverse().asDiagonal() * inverse);
    first_.push_back(static_cast<std::int32_t>(block_.size()));
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
