// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/plane/shape.h"

#include <string>

namespace crackle::plane {

/// How the chords of a shape's boundary approximate an ellipse.
struct ChordApproximation {
  int n_chords = 0;
  double longest = 0;  ///< [m]
  double inside = 0;   ///< largest distance of a chord's midpoint inside the curve, relative to the radius
  double area = 0;     ///< enclosed by the chords together with the centre, relative to the ellipse's
};

/// @param part name of the ellipse's part of the boundary
/// @param angle of the first semi-axis [rad]
ChordApproximation chord_approximation(const Shape& shape, const std::string& part, const Point& centre,
                                       const Point& semi_axes, double angle);

}  // namespace crackle::plane
