// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/input/profile.h"

#include "crackle/common/interpolation.h"

#include <algorithm>
#include <cmath>

namespace crackle::input {

double Profile::at(double coordinate) const {
  return interpolated(table, coordinate);
}

double Profile::largest_magnitude() const {
  double largest = 0;
  for (const auto& [coordinate, factor] : table) largest = std::max(largest, std::abs(factor));
  return largest;
}

}  // namespace crackle::input
