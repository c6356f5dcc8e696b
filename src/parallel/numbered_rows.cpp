// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/numbered_rows.h"

#include "parallel/collectives.h"

#include <algorithm>
#include <numeric>

namespace crackle::parallel {

std::span<const std::int64_t> NumberedRows::find(std::int64_t number) const {
  const auto place = std::ranges::lower_bound(numbers, number);
  if (place == numbers.end() || *place != number) return {};
  return std::span(values).subspan(width * static_cast<std::size_t>(place - numbers.begin()), width);
}

double NumberedRows::number_at(std::int64_t number) const {
  const auto row = find(number);
  return row.empty() ? 0 : std::bit_cast<double>(row.front());
}

NumberedRows gather_rows(const Communicator& group, const NumberedRows& local) {
  const auto numbers = gather_on_root(group, std::span<const std::int64_t>(local.numbers));
  const auto values = gather_on_root(group, std::span<const std::int64_t>(local.values));
  std::vector<std::size_t> order(numbers.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return numbers[i]; });
  NumberedRows rows;
  rows.width = local.width;
  rows.numbers.reserve(numbers.size());
  rows.values.reserve(values.size());
  for (const std::size_t i : order) {
    rows.numbers.push_back(numbers[i]);
    const auto row = std::span(values).subspan(rows.width * i, rows.width);
    rows.values.insert(rows.values.end(), row.begin(), row.end());
  }
  return rows;
}

}  // namespace crackle::parallel
