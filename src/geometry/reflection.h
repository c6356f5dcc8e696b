// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"

#include <array>
#include <string>
#include <vector>

namespace crackle::geometry {

/// Tolerance of coordinates on walls, relative to the body's largest size.
inline constexpr double wall_tolerance = 1e-12;

/// The shape does not refine a mesh that is nearly fine enough.
inline constexpr double fine_enough = 1.25;

/// Reflects coordinate i about the middle of a box if bit i of `axes` is set: two bits together are a
/// half-turn, three a reflection in the centre. It is its own inverse.
struct Reflection {
  unsigned axes;
  Box box;
  std::array<std::vector<double>, 3> planes;  ///< positions of the faces normal to each axis
  double near;                                ///< [m]

  /// Moved onto a plane of the body if close.
  Point operator()(const Point& p) const;
  std::string name() const;
  /// @param crack_start the image of each one
  Symmetry symmetry(std::vector<std::int32_t> crack_start) const;
};

}  // namespace crackle::geometry
