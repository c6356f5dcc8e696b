// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/index.h"
#include "crackle/common/real.h"
#include "crackle/common/vector.h"
#include "crackle/geometry/point.h"
#include "crackle/input/parameters.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace crackle::geometry {

using FaceId = std::int32_t;  ///< index into Body::faces(), or beyond for inner ones

/// A plane through the thickness: the points with dot(p, normal) = position. `normal` and `across` are
/// perpendicular unit vectors in the y-z plane.
struct CrossPlane {
  Vector normal;
  Vector across;             ///< the direction of the plane in the y-z plane
  double position;           ///< [m]
  double origin = 0;         ///< dot(p, across) at coordinate 0 [m]
  double length = infinity;  ///< if finite, the plane ends at the coordinates 0 and this [m]

  /// Coordinate of a point across, along the plane [m].
  double coordinate(const Point& p) const { return dot(p, across) - origin; }
  /// The point of the plane at this coordinate across; x is 0.
  Point at(double coordinate) const { return position * normal + (coordinate + origin) * across; }
  bool holds(double coordinate) const {
    return length == infinity || (coordinate >= 0 && coordinate <= length);
  }
};

/// The plane of a section; the coordinate across is z if y is constant, y if z is constant, and the distance
/// from its start on a line.
inline CrossPlane plane_of(const input::Section& section) {
  if (section.axis == 0) {
    const auto& [from, to] = section.line;
    const double length = std::hypot(to[0] - from[0], to[1] - from[1]);
    const Vector across{0, (to[0] - from[0]) / length, (to[1] - from[1]) / length};
    const Vector normal{0, across[2], -across[1]};
    const Point start{0, from[0], from[1]};
    return {normal, across, dot(start, normal), dot(start, across), length};
  }
  CrossPlane plane{{}, {}, section.position};
  plane.normal[index(section.axis)] = 1;
  plane.across[index(3 - section.axis)] = 1;
  return plane;
}

/// A place where cracks start, and the straight line along which they are followed through the body: its
/// ligament. Its number, the index into Body::crack_starts(), is called `notch` in the result files.
///
/// From a hole, or from the free surface, cracks can run in any direction. Such a start has no ligament:
/// is_straight is false, and only the members name, tip and faces are meaningful. cracks::crack_ligaments
/// finds the lines along which its cracks are followed.
struct CrackStart {
  std::string name;  ///< as shown in messages
  Point tip;         ///< at mid-thickness [m]; without a ligament, for drawing only
  Point end;         ///< of the ligament, on the surface ahead of the tip [m]
  /// Unit vectors in the y-z plane along and across the ligament. `along` points from the tip to the end if
  /// `direction` is 1, and back if it is -1: thus both can be coordinate axes, with coordinates bitwise equal
  /// to those of points.
  Vector along;
  Vector across;
  double direction;
  double ligament;            ///< its length [m]
  std::vector<FaceId> faces;  ///< cracks that touch one of these faces start here ...
  double reach;               ///< ... if no farther behind the tip than this [m]
  bool is_straight = true;    ///< true if it has a ligament
  /// True if all cracks that touch no other start belong to it, including those that begin inside the body.
  /// Its faces claim nothing. @pre !is_straight
  bool is_free_surface = false;
  /// True for a hole: cracks can run into it and go on from its other sides. @pre !is_straight
  bool is_hole = false;

  /// Distance of a point ahead of the tip, along the ligament [m].
  double advance(const Point& p) const { return direction * (dot(p, along) - dot(tip, along)); }

  /// The plane across the ligament at this advance.
  CrossPlane plane_at(double advance) const { return {along, across, dot(tip, along) + direction * advance}; }

  /// The advance at which the line of the ligament intersects a plane [m]; empty at less than 45 degrees,
  /// when a crack runs along the plane rather than across it.
  /// @pre is_straight
  std::optional<double> advance_to(const CrossPlane& plane) const {
    const double slope = direction * dot(plane.normal, along);
    if (2 * slope * slope < 1) return std::nullopt;
    return (plane.position - dot(plane.normal, tip)) / slope;
  }

  /// True if a crack that touches the surface at this point of this face starts here.
  bool claims(FaceId face, const Point& p) const {
    if (is_free_surface || (is_straight && -advance(p) > reach)) return false;
    return std::find(faces.begin(), faces.end(), face) != faces.end();
  }
};

}  // namespace crackle::geometry
