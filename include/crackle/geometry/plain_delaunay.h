// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/point.h"

#include <span>
#include <vector>

namespace crackle::geometry {

/// A Delaunay tessellation of points as CGAL makes it: what realizations are compared with.
struct PlainDelaunay {
  std::vector<Point> nodes;             ///< in the order in which CGAL holds them [m]
  std::vector<Tetrahedron> tetrahedra;  ///< likewise; of the convex hull, so notches are filled
  double seconds = 0;  ///< of one core for the tessellation alone, with CGAL's spatial sorting
};

/// @param points pairwise different, not all in one plane
PlainDelaunay plain_delaunay(std::span<const Point> points);

}  // namespace crackle::geometry
