// SPDX-License-Identifier: GPL-3.0-or-later
#include "wall_points.h"

#include "crackle/common/index.h"
#include "crackle/common/vector.h"

#include "notch_crossing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace crackle::geometry {

namespace {

/// The point where the segment passes through the surface, with the exact coordinate of the plane.
std::optional<Point> passage(const Surface& surface, const Point& p, const Point& q) {
  const auto axis = static_cast<std::size_t>(surface.axis);
  const double before = p[axis] - surface.position;
  const double after = q[axis] - surface.position;
  if (!((before < 0 && after > 0) || (before > 0 && after < 0))) return std::nullopt;
  const double share = before / (before - after);
  Point x{};
  for (std::size_t i = 0; i < 3; ++i) x[i] = p[i] + share * (q[i] - p[i]);
  x[axis] = surface.position;
  if (!surface.extent.contains(x)) return std::nullopt;
  return x;
}

/// The same point, or the nearest one of the outline if that is nearer than `margin` [m].
Point snapped_to_outline(const Surface& surface, Point p, double margin) {
  double nearest = margin;
  std::size_t nearest_axis = 0;
  double bound = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (static_cast<int>(i) == surface.axis) continue;
    for (const double limit : {surface.extent.lower[i], surface.extent.upper[i]})
      if (std::abs(p[i] - limit) < nearest) {
        nearest = std::abs(p[i] - limit);
        nearest_axis = i;
        bound = limit;
      }
  }
  if (nearest < margin) p[nearest_axis] = bound;
  return p;
}

}  // namespace

double distance_to_outline(const Body& body, SurfaceId id, const Point& p) {
  const Surface& surface = body.surfaces()[index(id)];
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i)
    if (static_cast<int>(i) != surface.axis)
      nearest = std::min({nearest, p[i] - surface.extent.lower[i], surface.extent.upper[i] - p[i]});
  if (Body::notch_of(id) < 0)
    for (int i = 0; i < body.n_notches(); ++i)
      if (distance(body.slot(i), surface.extent) == 0) nearest = std::min(nearest, distance(p, body.slot(i)));
  return nearest;
}

std::vector<Point> missing_wall_points(const Body& body, std::span<const Point> points,
                                       std::span<const double> spacing, std::span<const Tetrahedron> crossing,
                                       double margin) {
  std::vector<Point> added;
  for (const Tetrahedron& t : crossing) {
    const std::array<Point, 4> corners{points[index(t[0])], points[index(t[1])], points[index(t[2])],
                                       points[index(t[3])]};
    if (place(body.sections(), corners) != Place::crossing) continue;
    for (std::size_t id = 6; id < body.surfaces().size(); ++id)
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < i; ++j) {
          const auto x = passage(body.surfaces()[id], corners[i], corners[j]);
          if (!x) continue;
          const double local = (spacing[index(t[i])] + spacing[index(t[j])]) / 2;
          const Point p = snapped_to_outline(body.surfaces()[id], *x, margin * local);
          if (body.movable_axes(p) != 0 && std::none_of(added.begin(), added.end(), [&](const Point& other) {
                return norm(difference(p, other)) < 0.5 * local;
              }))
            added.push_back(p);
        }
  }
  return added;
}

}  // namespace crackle::geometry
