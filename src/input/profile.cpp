// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/input/profile.h"

#include <algorithm>
#include <cmath>

namespace crackle::input {

double Profile::at(double coordinate) const {
  if (coordinate <= table.front().first) return table.front().second;
  for (std::size_t i = 1; i < table.size(); ++i) {
    const auto [x0, f0] = table[i - 1];
    const auto [x1, f1] = table[i];
    if (coordinate <= x1) return f0 + (f1 - f0) * ((coordinate - x0) / (x1 - x0));
  }
  return table.back().second;
}

double Profile::largest_magnitude() const {
  double largest = 0;
  for (const auto& [coordinate, factor] : table) largest = std::max(largest, std::abs(factor));
  return largest;
}

}  // namespace crackle::input
