// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/geometry/point.h"

#include <span>
#include <vector>

namespace crackle::geometry {

/// Points to add where tetrahedra reach through the surface: where their edges pass through a face, exactly
/// in the face, or exactly on its outline when that is nearer than `margin` spacings. Points closer than half
/// a spacing to an earlier one are left out.
/// @param crossing the tetrahedra, as nodes of `points`; those that do not reach through are passed over
std::vector<Point> missing_face_points(const Body& body, std::span<const Point> points,
                                       std::span<const double> spacing, std::span<const Tetrahedron> crossing,
                                       double margin);

}  // namespace crackle::geometry
