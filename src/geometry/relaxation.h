// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/geometry/mother_points.h"

#include <functional>

namespace crackle::geometry {

/// True if point i may move to p.
using MayMove = std::function<bool(std::size_t i, const Point& p)>;

/// One round of optimal Delaunay triangulation (Chen and Xu 2004): every point moves to the mean of the
/// circumcentres of its tetrahedra or, on a surface, of its boundary triangles, weighted such that the
/// spacing is preserved. Points on edges, and points of tetrahedra that cross the surface, are not moved.
void relax(const Body& body, MotherPoints& points, const MayMove& may_move);

}  // namespace crackle::geometry
