// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/point.h"
#include "crackle/plane/side_index.h"

/// Bits of Body::movable for bodies whose faces are normal to x or contain its direction.
namespace crackle::geometry {

inline constexpr unsigned along_x = 1;
inline constexpr unsigned along_y = 2;
inline constexpr unsigned along_z = 4;
inline constexpr unsigned along_wall = 8;  ///< in the plane of the plate, on a wall normal to neither y nor z

inline plane::Point in_plane(const Point& p) {
  return {p[1], p[2]};
}

inline Point at(double x, const plane::Point& p) {
  return {x, p[0], p[1]};
}

inline unsigned direction_of(const plane::Side& side) {
  return side.along[0] == 0 ? along_z : side.along[1] == 0 ? along_y : along_wall;
}

}  // namespace crackle::geometry
