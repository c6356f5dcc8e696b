// SPDX-License-Identifier: GPL-3.0-or-later
#include "notch_crossing.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>

namespace crackle::geometry {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using PlanePoint = Kernel::Point_2;
using Quadrilateral = std::array<PlanePoint, 4>;

/// True when all points lie on the line through p and q or on the side of it that `sign` names.
bool on_side(const Quadrilateral& points, const PlanePoint& p, const PlanePoint& q, int sign) {
  return std::all_of(points.begin(), points.end(), [&](const PlanePoint& point) {
    return static_cast<int>(CGAL::orientation(p, q, point)) * sign >= 0;
  });
}

/// True when a line through two of the projected corners has them on one side and the slot on the other. With
/// the slot's own sides, tested before, these are all the directions that can separate two convex polygons.
bool separated(const Quadrilateral& projection, const Quadrilateral& slot) {
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      const PlanePoint& p = projection[i];
      const PlanePoint& q = projection[j];
      if (p == q) continue;
      for (const int sign : {1, -1})
        if (on_side(projection, p, q, sign) && on_side(slot, p, q, -sign)) return true;
    }
  return false;
}

Place place(const SlotSection& section, const std::array<Point, 4>& corners) {
  const auto at_axis = static_cast<std::size_t>(section.at_axis);
  const auto depth_axis = static_cast<std::size_t>(section.depth_axis);
  const double lower = std::min(section.mouth, section.tip);
  const double upper = std::max(section.mouth, section.tip);
  int n_below = 0;
  int n_above = 0;
  int n_beyond = 0;  // the tip; beyond the mouth there is no body
  int n_inside = 0;
  for (const Point& corner : corners) {
    const double a = corner[at_axis];
    const double d = corner[depth_axis];
    n_below += a <= section.lower;
    n_above += a >= section.upper;
    n_beyond += section.tip > section.mouth ? d >= section.tip : d <= section.tip;
    n_inside += section.lower <= a && a <= section.upper && lower <= d && d <= upper;
  }
  if (n_inside == 4) return Place::cavity;
  if (n_below == 4 || n_above == 4 || n_beyond == 4) return Place::solid;
  Quadrilateral projection;
  for (std::size_t i = 0; i < 4; ++i) projection[i] = PlanePoint(corners[i][at_axis], corners[i][depth_axis]);
  const Quadrilateral slot{PlanePoint(section.lower, lower), PlanePoint(section.upper, lower),
                           PlanePoint(section.upper, upper), PlanePoint(section.lower, upper)};
  return separated(projection, slot) ? Place::solid : Place::crossing;
}

}  // namespace

Place place(std::span<const SlotSection> sections, const std::array<Point, 4>& corners) {
  for (const SlotSection& section : sections) {
    const Place result = place(section, corners);
    if (result != Place::solid) return result;
  }
  return Place::solid;
}

}  // namespace crackle::geometry
