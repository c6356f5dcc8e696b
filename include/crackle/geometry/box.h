// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/point.h"

namespace crackle::geometry {

/// The closed box lower <= p <= upper, by coordinate.
struct Box {
  Point lower;
  Point upper;
  bool contains(const Point& p) const {
    return lower[0] <= p[0] && p[0] <= upper[0] && lower[1] <= p[1] && p[1] <= upper[1] && lower[2] <= p[2] &&
           p[2] <= upper[2];
  }
};

/// Euclidean distances [m]; 0 where the sets meet.
double distance(const Point& p, const Box& box);
double distance(const Box& a, const Box& b);

/// The box of the points between two boxes: along each axis their common interval or the gap between them.
Box between(const Box& a, const Box& b);

}  // namespace crackle::geometry
