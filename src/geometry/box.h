// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "geometry/point.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace crackle::geometry {

/// The axis-aligned box lower <= p <= upper.
struct Box {
  Point lower;
  Point upper;
  bool contains(const Point& p) const {
    return lower[0] <= p[0] && p[0] <= upper[0] && lower[1] <= p[1] && p[1] <= upper[1] && lower[2] <= p[2] &&
           p[2] <= upper[2];
  }

  /// Extends the box to include a point.
  void include(const Point& p) {
    for (std::size_t i = 0; i < 3; ++i) {
      lower[i] = std::min(lower[i], p[i]);
      upper[i] = std::max(upper[i], p[i]);
    }
  }
};

/// The empty box.
inline constexpr Box nowhere{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};

/// The first axis along which the box is longest.
std::size_t longest_axis(const Box& box);

/// Bit i of a corner's number is set if it is at the upper end of axis i.
std::array<Point, 8> corners_of(const Box& box);

/// Euclidean distances [m]; 0 if the sets intersect.
double distance(const Point& p, const Box& box);
double distance(const Box& a, const Box& b);

}  // namespace crackle::geometry
