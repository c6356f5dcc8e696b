// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parallel/communicator.h"

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

namespace crackle::parallel {

/// Rows of 64-bit words, each with its node's or tetrahedron's number in the realization: a table independent
/// of the distribution over ranks.
struct NumberedRows {
  std::size_t width = 1;
  std::vector<std::int64_t> numbers;  ///< ascending once gathered
  std::vector<std::int64_t> values;   ///< `width` per number

  void add(std::int64_t number, std::int64_t value) {
    numbers.push_back(number);
    values.push_back(value);
  }
  void add(std::int64_t number, double value) { add(number, std::bit_cast<std::int64_t>(value)); }

  /// The row of a number; empty if there is none. For gathered rows.
  std::span<const std::int64_t> find(std::int64_t number) const;
  /// The single word of a row as a floating-point number; 0 if there is no row. For gathered rows of width 1.
  double number_at(std::int64_t number) const;
};

/// The rows of all ranks, sorted by number, on the root; empty elsewhere. Collective.
NumberedRows gather_rows(const Communicator& group, const NumberedRows& local);

/// For a Packer. @throws std::runtime_error when the number of values does not match the rows
void for_each_field(std::derived_from<NumberedRows> auto& rows, const auto& visit) {
  visit(rows.width, rows.numbers, rows.values);
  if (rows.width * rows.numbers.size() != rows.values.size())
    throw std::runtime_error("a packed table has not as many values as rows");
}

}  // namespace crackle::parallel
