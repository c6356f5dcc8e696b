// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/index.h"
#include "crackle/common/vector.h"
#include "crackle/geometry/point.h"
#include "crackle/input/parameters.h"

#include <algorithm>
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
  Vector across;    ///< the direction of the plane in the y-z plane
  double position;  ///< [m]

  /// The place in the plane at this coordinate across, dot(p, across); x is 0.
  Point at(double coordinate) const { return position * normal + coordinate * across; }
};

/// The plane of a section; coordinates across are z where y is const, y where z is const.
inline CrossPlane plane_of(const input::Section& section) {
  CrossPlane plane{{}, {}, section.position};
  plane.normal[index(section.axis)] = 1;
  plane.across[index(3 - section.axis)] = 1;
  return plane;
}

/// A place where cracks start, and the straight way on which they are followed from there through the body:
/// its ligament. Its number, the index into Body::crack_starts(), is called `notch` in the result files.
struct CrackStart {
  std::string name;  ///< as messages show it
  Point tip;         ///< in the middle of the thickness [m]
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

  /// How far a point is ahead of the tip, along the ligament [m].
  double advance(const Point& p) const { return direction * (dot(p, along) - dot(tip, along)); }

  /// The plane across the ligament at this advance.
  CrossPlane plane_at(double advance) const { return {along, across, dot(tip, along) + direction * advance}; }

  /// The advance at which the line of the ligament meets a plane [m]; nothing where it makes less than 45
  /// degrees with the plane, so that a crack runs along the plane more than across it.
  std::optional<double> advance_to(const CrossPlane& plane) const {
    const double slope = direction * dot(plane.normal, along);
    if (2 * slope * slope < 1) return std::nullopt;
    return (plane.position - dot(plane.normal, tip)) / slope;
  }

  /// Whether a crack that touches the surface in this point of this face starts here.
  bool claims(FaceId face, const Point& p) const {
    return -advance(p) <= reach && std::find(faces.begin(), faces.end(), face) != faces.end();
  }
};

}  // namespace crackle::geometry
