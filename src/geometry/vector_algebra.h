// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/point.h"

#include <cmath>

namespace crackle::geometry {

inline Point difference(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline double dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline double norm(const Point& a) {
  return std::sqrt(dot(a, a));
}

}  // namespace crackle::geometry
