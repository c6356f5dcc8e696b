// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/complex.h"
#include "plane/side_index.h"

#include <cstddef>
#include <string>
#include <vector>

/// Plane shapes extruded along x.
namespace crackle::geometry {

inline plane::Point in_plane(const Point& p) {
  return {p[1], p[2]};
}

inline Point at(double x, const plane::Point& p) {
  return {x, p[0], p[1]};
}

/// Faces 0 and 1 of a plate are x-min and x-max, face first_wall + s is the wall on side s of the shape.
inline constexpr std::size_t first_wall = 2;

/// The rectangle on a side of a plane shape, between two levels of x [m]; the body is to its left.
Face wall(const plane::Side& side, double lower, double upper, std::vector<std::string> names);

/// A plane shape extruded from x = 0 to the thickness.
///
/// In a box, cracks start at the tips of its slots and are followed along their ligaments. In other plates
/// they start, in any direction, at each notch, at each hole and on the free surface.
/// @pre specimen.shape is consistent with the other members of the specimen
/// @throws std::runtime_error as plane::shape_of
Complex plate(const plane::Specimen& specimen);

/// The lengths of the walls of a plate, their distances, and the tips of its slots.
SpacingRule plate_spacing(const plane::Specimen& specimen);

}  // namespace crackle::geometry
