// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/vector.h"

#include <cstddef>
#include <utility>
#include <vector>

namespace crackle::input {

/// Factors by a time [s] or a coordinate [m], ascending; linear between the entries, constant outside.
using FactorTable = std::vector<std::pair<double, double>>;

/// A factor as a function of one coordinate.
struct Profile {
  std::size_t axis = 0;
  FactorTable table = {};

  double at(double coordinate) const;
  double at(const Vector& point) const { return at(point[axis]); }
  double largest_magnitude() const;
  bool operator==(const Profile&) const = default;
};

}  // namespace crackle::input
