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

using FaceId = std::int32_t;  ///< index into Body::faces()

/// A plane through the thickness: the points with dot(p, normal) = position. `normal` and `across` are
/// perpendicular unit vectors in the y-z plane.
struct CrossPlane {
  Vector normal;
  Vector across;             ///< the direction of the plane in the y-z plane
  double position;           ///< [m]
  double origin = 0;         ///< dot(p, across) where the coordinate across is 0 [m]
  double length = infinity;  ///< where not infinite, the plane ends at the coordinates 0 and this [m]

  /// How far a point is across, along the plane [m].
  double coordinate(const Point& p) const { return dot(p, across) - origin; }
  /// The place in the plane at this coordinate across; x is 0.
  Point at(double coordinate) const { return position * normal + (coordinate + origin) * across; }
  bool holds(double coordinate) const {
    return length == infinity || (coordinate >= 0 && coordinate <= length);
  }
};

/// The plane of a section; coordinates across are z where y is const, y where z is const, and the distance
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

/// A place where cracks start, and the straight way on which they are followed from there through the body:
/// its ligament. Its number, the index into Body::crack_starts(), is called `notch` in the result files.
///
/// From a hole, or anywhere on the surface, cracks can run in any direction. Such a start has no ligament:
/// is_straight is false, and of the members only name, tip and faces have a meaning. analysis::crack_ways
/// tells along which ways its cracks are followed.
struct CrackStart {
  std::string name;  ///< as messages show it
  Point tip;         ///< in the middle of the thickness [m]; where there is no ligament, for drawing
  Point end;         ///< of the ligament, on the surface ahead of the tip [m]
  /// Unit vectors in the y-z plane along the ligament and across it. `along` points from the tip to the end
  /// where `direction` is 1 and back where it is -1: so both can be axes of the coordinates, and coordinates
  /// along them those of points, bit by bit.
  Vector along;
  Vector across;
  double direction;
  double ligament;            ///< its length [m]
  std::vector<FaceId> faces;  ///< a crack starts here that touches one of these faces ...
  double reach;               ///< ... no further behind the tip than this [m]
  bool is_straight = true;    ///< whether it has a ligament
  /// Whether it has all cracks that touch no other start, those that begin inside the body too. Its faces
  /// claim nothing. @pre !is_straight
  bool is_free_surface = false;

  /// How far a point is ahead of the tip, along the ligament [m].
  double advance(const Point& p) const { return direction * (dot(p, along) - dot(tip, along)); }

  /// The plane across the ligament at this advance.
  CrossPlane plane_at(double advance) const { return {along, across, dot(tip, along) + direction * advance}; }

  /// The advance at which the line of the ligament meets a plane [m]; nothing where it makes less than 45
  /// degrees with the plane, so that a crack runs along the plane more than across it.
  /// @pre is_straight
  std::optional<double> advance_to(const CrossPlane& plane) const {
    const double slope = direction * dot(plane.normal, along);
    if (2 * slope * slope < 1) return std::nullopt;
    return (plane.position - dot(plane.normal, tip)) / slope;
  }

  /// Whether a crack that touches the surface in this point of this face starts here.
  bool claims(FaceId face, const Point& p) const {
    if (is_free_surface || (is_straight && -advance(p) > reach)) return false;
    return std::find(faces.begin(), faces.end(), face) != faces.end();
  }
};

}  // namespace crackle::geometry
