// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/geometry/point.h"

#include <span>
#include <vector>

namespace crackle::geometry {

/// Distance from a point of a surface to the outline of that plane piece [m].
double distance_to_outline(const Body& body, SurfaceId id, const Point& p);

/// Points to add where tetrahedra reach through the walls or tips of notches: where their edges pass through,
/// exactly on the wall or tip, or exactly on its outline when that is nearer than `margin` spacings. Points
/// closer than half a spacing to an earlier one are left out.
/// @param crossing the tetrahedra, as nodes of `points`; those that cross no notch are passed over
std::vector<Point> missing_wall_points(const Body& body, std::span<const Point> points,
                                       std::span<const double> spacing, std::span<const Tetrahedron> crossing,
                                       double margin);

}  // namespace crackle::geometry
