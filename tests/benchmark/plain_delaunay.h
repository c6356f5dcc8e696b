// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/point.h"

#include <span>
#include <vector>

namespace crackle::geometry {

/// A Delaunay tessellation of points as made by CGAL, for comparison with realizations.
struct PlainDelaunay {
  std::vector<Point> nodes;             ///< in CGAL's order [m]
  std::vector<Tetrahedron> tetrahedra;  ///< likewise; of the convex hull, so notches are filled
  double seconds = 0;                   ///< on one core, tessellation only, with CGAL's spatial sorting
};

/// @param points pairwise different, not all coplanar
PlainDelaunay plain_delaunay(std::span<const Point> points);

}  // namespace crackle::geometry
