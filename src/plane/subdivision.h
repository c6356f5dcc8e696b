// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "plane/shape.h"

#include <array>
#include <vector>

namespace crackle::plane {

/// A plate divided by the outlines of figures, which may overlap, coincide and extend beyond it.
struct Subdivision {
  /// A straight line between two corners, without another one in between.
  struct Line {
    std::array<int, 2> end;  ///< corners; the plate lies to the left of a line on its boundary
    int side = -1;           ///< of the plate on which it lies, counted over all loops; -1 inside the plate
    std::vector<int> left;   ///< the figures on its left, ascending
    std::vector<int> right;  ///< on its right; empty on the boundary
  };

  std::vector<Point> corners;    ///< those of the plate first, in the order of its loops
  std::vector<Line> lines;       ///< on the boundary of the plate and inside it
  std::vector<Polygon> figures;  ///< counter-clockwise outlines, with the corners of the lines on them
};

/// Corners of figures that are closer than the tolerance to another corner or line are moved onto it; those
/// of the plate stay. Coordinates along y and z of points on sides along these axes are exactly equal.
/// @param figures counter-clockwise
/// @param tolerance [m]
/// @throws std::runtime_error when figures are too small for the tolerance
Subdivision subdivide(const Shape& plate, const std::vector<Polygon>& figures, double tolerance);

/// The area that a figure has in common with another one [m^2].
/// @param other simple, counter-clockwise
double common_area(const Shape& shape, const Polygon& other);

}  // namespace crackle::plane
