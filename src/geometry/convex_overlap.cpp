// SPDX-License-Identifier: GPL-3.0-or-later
#include "convex_overlap.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>

namespace crackle::geometry {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

/// True if all points lie on the line through p and q or on the side of it given by `sign`.
bool on_side(std::span<const PlanePoint> points, const PlanePoint& p, const PlanePoint& q, int sign) {
  const auto kernel_point = [](const PlanePoint& r) { return Kernel::Point_2(r[0], r[1]); };
  return std::all_of(points.begin(), points.end(), [&](const PlanePoint& point) {
    return static_cast<int>(CGAL::orientation(kernel_point(p), kernel_point(q), kernel_point(point))) *
               sign >=
           0;
  });
}

}  // namespace

bool overlap(const std::array<PlanePoint, 4>& points, std::span<const PlanePoint> polygon) {
  // Two convex polygons can only be separated by a line along one of their sides.
  const auto separates = [&](const PlanePoint& p, const PlanePoint& q) {
    return p != q && ((on_side(points, p, q, 1) && on_side(polygon, p, q, -1)) ||
                      (on_side(points, p, q, -1) && on_side(polygon, p, q, 1)));
  };
  for (std::size_t i = 0; i < polygon.size(); ++i)
    if (separates(polygon[i], polygon[(i + 1) % polygon.size()])) return false;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j)
      if (separates(points[i], points[j])) return false;
  return true;
}

}  // namespace crackle::geometry
