// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <utility>

namespace crackle {

/// Linear interpolation in a table of ascending arguments and values, constant beyond its ends.
inline double interpolated(std::span<const std::pair<double, double>> table, double at) {
  if (at <= table.front().first) return table.front().second;
  for (std::size_t i = 1; i < table.size(); ++i) {
    const auto [x0, y0] = table[i - 1];
    const auto [x1, y1] = table[i];
    if (at <= x1) return y0 + (y1 - y0) * ((at - x0) / (x1 - x0));
  }
  return table.back().second;
}

}  // namespace crackle
