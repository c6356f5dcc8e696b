// SPDX-License-Identifier: GPL-3.0-or-later
// Location of points and tetrahedra in an extruded plate.
#include "extruded_plate.h"
#include "plane_directions.h"

#include <algorithm>
#include <cmath>

namespace crackle::geometry {

bool ExtrudedPlate::contains(const Point& p) const {
  return p[0] >= 0 && p[0] <= thickness() && index_.contains(in_plane(p));
}

bool ExtrudedPlate::in_face(FaceId face, const Point& p) const {
  if (index(face) < first_wall) return p[0] == (face == 0 ? 0 : thickness()) && index_.contains(in_plane(p));
  const plane::Side& side = side_of(face);
  if (p[0] < 0 || p[0] > thickness() || !index_.is_on(side, in_plane(p))) return false;
  // On a wall normal to an axis the coordinates are equal.
  return (side.along[0] != 0 || p[1] == side.from[0]) && (side.along[1] != 0 || p[2] == side.from[1]);
}

std::uint8_t ExtrudedPlate::movable(const Point& p) const {
  int n_sides = 0;
  unsigned directions = along_y | along_z;
  index_.for_sides_at(in_plane(p), [&](std::size_t number) {
    const plane::Side& side = index_.sides()[number];
    // A point within the tolerance of a wall normal to an axis, but not on it, is in the interior.
    if ((side.along[0] == 0 && p[1] != side.from[0]) || (side.along[1] == 0 && p[2] != side.from[1])) return;
    directions = direction_of(side);
    ++n_sides;
  });
  if (n_sides > 1) directions = 0;
  if (p[0] != 0 && p[0] != thickness()) directions |= along_x;
  return static_cast<std::uint8_t>(directions);
}

Directions ExtrudedPlate::directions(const Point& p, std::uint8_t movable) const {
  Directions result{};
  for (unsigned i = 0; i < 3; ++i)
    if ((movable >> i) & 1u) result.vector[index(result.n++)][i] = 1;
  if (movable & along_wall)
    index_.for_sides_at(in_plane(p), [&](std::size_t number) {
      const plane::Side& side = index_.sides()[number];
      if (direction_of(side) != along_wall || (result.n > 0 && result.vector[index(result.n - 1)][0] == 0))
        return;
      result.vector[index(result.n++)] = {0, side.along[0], side.along[1]};
    });
  return result;
}

double ExtrudedPlate::distance_to_surface(const Point& p) const {
  const double along_x = std::min(p[0], thickness() - p[0]);
  return std::min(along_x, contains(p) ? index_.distance(in_plane(p), along_x) : 0.0);
}

double ExtrudedPlate::distance_to_outline(FaceId face, const Point& p) const {
  if (index(face) < first_wall) return index_.contains(in_plane(p)) ? index_.distance(in_plane(p)) : 0;
  const plane::Side& side = side_of(face);
  const double arc_length = side.arc_length(in_plane(p));
  return std::min({p[0], thickness() - p[0], arc_length, side.length - arc_length});
}

std::optional<Point> ExtrudedPlate::passage(FaceId face, const Point& p, const Point& q,
                                            double margin) const {
  if (index(face) < first_wall) return std::nullopt;  // nothing beyond
  const plane::Side& side = side_of(face);
  const double before = side.height(in_plane(p));
  const double after = side.height(in_plane(q));
  const double near = index_.tolerance();
  if (!((before < -near && after > near) || (before > near && after < -near))) return std::nullopt;
  const Point meeting = p + before / (before - after) * (q - p);
  double x = meeting[0];
  double arc_length = side.arc_length(in_plane(meeting));
  if (arc_length < 0 || arc_length > side.length || x < 0 || x > thickness()) return std::nullopt;
  // Move onto the nearest edge, if close.
  const double nearest = std::min({x, thickness() - x, arc_length, side.length - arc_length});
  if (nearest < margin) {
    if (nearest == x)
      x = 0;
    else if (nearest == thickness() - x)
      x = thickness();
    else
      arc_length = nearest == arc_length ? 0 : side.length;
  }
  if (arc_length == 0) return Point{x, side.from[0], side.from[1]};
  if (arc_length == side.length) return Point{x, side.to[0], side.to[1]};
  return Point{x, side.from[0] + arc_length * side.along[0], side.from[1] + arc_length * side.along[1]};
}

Point ExtrudedPlate::snapped(const Point& p, double tolerance) const {
  Point result = p;
  for (const double x : {0.0, thickness()})
    if (std::abs(p[0] - x) <= tolerance) result[0] = x;
  const plane::Point place = in_plane(p);
  for (const plane::Side& side : index_.sides())
    if (plane::distance(place, side.from, side.to) <= tolerance) {
      const double arc_length = std::clamp(side.arc_length(place), 0.0, side.length);
      if (direction_of(side) != along_y) result[1] = side.from[0] + arc_length * side.along[0];
      if (direction_of(side) != along_z) result[2] = side.from[1] + arc_length * side.along[1];
    }
  for (const plane::Side& side : index_.sides())
    if (plane::norm({place[0] - side.from[0], place[1] - side.from[1]}) <= tolerance) {
      result[1] = side.from[0];
      result[2] = side.from[1];
    }
  return result;
}

Containment ExtrudedPlate::classify(const std::array<Point, 4>& corners) const {
  switch (index_.cover(
      {in_plane(corners[0]), in_plane(corners[1]), in_plane(corners[2]), in_plane(corners[3])})) {
    case plane::Cover::inside:
      return Containment::inside;
    case plane::Cover::outside:
      return Containment::outside;
    case plane::Cover::crossing:
      break;
  }
  return Containment::straddling;
}

}  // namespace crackle::geometry
