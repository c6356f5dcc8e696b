// SPDX-License-Identifier: GPL-3.0-or-later
// Location of points and tetrahedra in a notched box.
#include "convex_overlap.h"
#include "notched_box.h"

#include <algorithm>
#include <cmath>

namespace crackle::geometry {

namespace {

Place place(const SlotSection& section, const std::array<Point, 4>& corners) {
  const auto at_axis = static_cast<std::size_t>(section.at_axis);
  const auto depth_axis = static_cast<std::size_t>(section.depth_axis);
  const double lower = std::min(section.mouth, section.tip);
  const double upper = std::max(section.mouth, section.tip);
  int n_below = 0;
  int n_above = 0;
  int n_beyond = 0;  // beyond the tip; beyond the mouth there is no body
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
  std::array<PlanePoint, 4> projection;
  for (std::size_t i = 0; i < 4; ++i) projection[i] = {corners[i][at_axis], corners[i][depth_axis]};
  const std::array<PlanePoint, 4> slot{
      {{section.lower, lower}, {section.upper, lower}, {section.upper, upper}, {section.lower, upper}}};
  return overlap(projection, slot) ? Place::crossing : Place::solid;
}

}  // namespace

bool NotchedBox::contains(const Point& p) const {
  if (!bounds().contains(p)) return false;
  return std::none_of(sections_.begin(), sections_.end(), [&](const SlotSection& section) {
    const double a = p[index(section.at_axis)];
    const double d = p[index(section.depth_axis)];
    const bool before_tip = section.tip > section.mouth ? d < section.tip : d > section.tip;
    return section.lower < a && a < section.upper && before_tip;
  });
}

std::uint8_t NotchedBox::movable(const Point& p) const {
  unsigned fixed = 0;
  for (std::size_t i = 0; i < 3; ++i)
    if (p[i] == 0 || p[i] == bounds().upper[i]) fixed |= 1u << i;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (!slots_[i].contains(p)) continue;
    const SlotSection& section = sections_[i];
    const double a = p[index(section.at_axis)];
    if (a == section.lower || a == section.upper) fixed |= 1u << section.at_axis;
    if (p[index(section.depth_axis)] == section.tip) fixed |= 1u << section.depth_axis;
  }
  return static_cast<std::uint8_t>(7u & ~fixed);
}

Directions NotchedBox::directions(const Point&, std::uint8_t movable) const {
  Directions result{};
  for (unsigned i = 0; i < 3; ++i)
    if ((movable >> i) & 1u) result.vector[index(result.n++)][i] = 1;
  return result;
}

double NotchedBox::distance_to_surface(const Point& p) const {
  double nearest = infinity;
  for (std::size_t i = 0; i < 3; ++i) nearest = std::min({nearest, p[i], bounds().upper[i] - p[i]});
  for (const Box& slot : slots_) nearest = std::min(nearest, distance(p, slot));
  return nearest;
}

double NotchedBox::distance_to_outline(FaceId face, const Point& p) const {
  const Box& rectangle = faces()[index(face)].patch.domain;
  double nearest = infinity;
  for (std::size_t i = 0; i < 3; ++i)
    if (static_cast<int>(i) != axis_[index(face)])
      nearest = std::min({nearest, p[i] - rectangle.lower[i], rectangle.upper[i] - p[i]});
  if (face < 6)
    for (const Box& slot : slots_)
      if (distance(slot, rectangle) == 0) nearest = std::min(nearest, distance(p, slot));
  return nearest;
}

std::optional<Point> NotchedBox::passage(FaceId face, const Point& p, const Point& q, double margin) const {
  const Box& rectangle = faces()[index(face)].patch.domain;
  const std::size_t axis = index(axis_[index(face)]);
  const double position = rectangle.lower[axis];
  const double before = p[axis] - position;
  const double after = q[axis] - position;
  if (!((before < 0 && after > 0) || (before > 0 && after < 0))) return std::nullopt;
  const double share = before / (before - after);
  Point x = p + share * (q - p);
  x[axis] = position;
  if (!rectangle.contains(x)) return std::nullopt;

  double nearest = margin;
  std::size_t nearest_axis = axis;
  double bound = position;
  for (std::size_t i = 0; i < 3; ++i) {
    if (i == axis) continue;
    for (const double limit : {rectangle.lower[i], rectangle.upper[i]})
      if (std::abs(x[i] - limit) < nearest) {
        nearest = std::abs(x[i] - limit);
        nearest_axis = i;
        bound = limit;
      }
  }
  x[nearest_axis] = bound;
  return x;
}

Point NotchedBox::snapped(const Point& p, double tolerance) const {
  Point result = p;
  for (std::size_t face = 0; face < faces().size(); ++face) {
    const Box& rectangle = faces()[face].patch.domain;
    const std::size_t axis = index(axis_[face]);
    Point q = result;
    q[axis] = rectangle.lower[axis];
    if (std::abs(result[axis] - q[axis]) <= tolerance && distance(q, rectangle) <= tolerance) result = q;
  }
  return result;
}

Place NotchedBox::place(const std::array<Point, 4>& corners) const {
  for (const SlotSection& section : sections_) {
    const Place result = geometry::place(section, corners);
    if (result != Place::solid) return result;
  }
  return Place::solid;
}

}  // namespace crackle::geometry
