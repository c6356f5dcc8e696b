// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"

#include <array>
#include <string>
#include <vector>

namespace crackle::geometry {

/// Of coordinates on walls, in the body's largest size.
inline constexpr double wall_tolerance = 1e-12;

/// A shape is not followed where the mesh is nearly as fine as it.
inline constexpr double fine_enough = 1.25;

/// Reflects coordinate i in the middle of a box wherever bit i of `axes` is set: two bits together are a
/// half-turn, three a reflection in the centre. It is its own inverse.
struct Reflection {
  unsigned axes;
  Box box;
  std::array<std::vector<double>, 3> planes;  ///< positions of the faces across each axis
  double near;                                ///< [m]

  /// On a plane of the body if it comes near.
  Point operator()(const Point& p) const;
  std::string name() const;
  /// @param crack_start that each one is mapped on
  Symmetry symmetry(std::vector<std::int32_t> crack_start) const;
};

}  // namespace crackle::geometry
