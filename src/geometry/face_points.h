// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/geometry/point.h"

#include <span>
#include <vector>

namespace crackle::geometry {

/// Points to add where tetrahedra cross the surface: where their edges intersect a face, exactly in the face,
/// or exactly on its outline if that is closer than `margin` spacings. Points closer than half a spacing to
/// an earlier one are omitted.
/// @param crossing the tetrahedra, as nodes of `points`; those that do not cross the surface are skipped
std::vector<Point> missing_face_points(const Body& body, std::span<const Point> points,
                                       std::span<const double> spacing, std::span<const Tetrahedron> crossing,
                                       double margin);

}  // namespace crackle::geometry
