// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "common/real.h"
#include "common/vector.h"
#include "geometry/box.h"
#include "geometry/point.h"
#include "input/model.h"
#include "input/section.h"
#include "plane/shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace crackle::geometry {

using FaceId = std::int32_t;  ///< number of a face; those of inner faces follow those of the surface

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

/// A box with arbitrary position and orientation; a rectangle if it has no extent along one of its own axes.
struct Patch {
  Box domain;  ///< in own coordinates [m]
  Point origin{};
  std::array<Vector, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< orthonormal

  Point at(const Point& own) const;  ///< the point with the given own coordinates
  Point own(const Point& p) const;   ///< own coordinates of a point
  Box bounds(const Box& own) const;  ///< bounding box of a part of the domain
  Box bounds() const { return bounds(domain); }
};

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
  /// True for a crack that is there from the start, or all random flaws: cracks that touch a tetrahedron that
  /// it opens start there, whatever faces they touch. @pre !is_straight
  bool is_pre_crack = false;
  std::optional<Patch> plane = {};  ///< of a pre-crack, see PreCrackFigure
  std::vector<Point> border = {};   ///< likewise

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

/// A plane facet: of the body's surface, or inside it where two materials meet.
struct Face {
  /// Names in boundary conditions, which several faces may share; the first one is for messages.
  std::vector<std::string> names;
  double area;     ///< exact [m^2]
  Vector outward;  ///< unit normal; either one of an inner face
  Patch patch;     ///< a rectangle that contains the face
  /// Its border in any order, in the own coordinates that span the patch, ascending.
  std::vector<std::array<plane::Point, 2>> rim = {};

  /// The own axes of the patch that span the face, ascending.
  std::array<std::size_t, 2> spanning_axes() const;
};

/// A straight edge between two corners: on the border of faces, or a line within a face.
class Edge {
public:
  Edge(const Point& from, const Point& to);
  const Point& from() const { return from_; }
  const Point& to() const { return to_; }
  double length() const { return length_; }  ///< [m]
  const Vector& direction() const { return direction_; }
  Point at(double length) const;          ///< the point at this distance from its start
  Point nearest(const Point& p) const;    ///< exactly an end if that is nearest
  double distance(const Point& p) const;  ///< [m]
  Box bounds() const;

private:
  Point from_, to_;
  double length_;
  Vector direction_;
};

/// A source of mesh refinement: a box or, if `wall` is given, a wall through the whole thickness.
struct SpacingSource {
  Box region;                                            ///< contains the wall, if any
  double spacing;                                        ///< maximum in the region [m]
  double growth;                                         ///< per unit distance from the region
  std::string reason;                                    ///< for messages, such as "the length of edge-0"
  std::optional<std::array<plane::Point, 2>> wall = {};  ///< its ends in the y-z plane
  int condition = -1;  ///< number of the boundary condition whose region requires it, if any

  double at(const Point& p) const;            ///< the required spacing at a point [m]
  double lower_bound(const Box& part) const;  ///< over a part of the body [m]
  double upper_bound(const Box& part) const;  ///< likewise
};

/// Growth away from places where the body's shape, not the input, requires a fine spacing.
inline double shape_growth(const input::Mesh& mesh) {
  return std::max(mesh.growth, 0.2);
}

using plane::Polygon;

class Body;

/// Appends the sources of refinement that a feature of the body requires, such as a narrow gap.
/// @param sources those of the features before it; the mesh regions of the input are not among them
using SpacingRule =
    std::function<void(const Body& body, const input::Mesh& mesh, std::vector<SpacingSource>& sources)>;

/// A body as it is built: a polyhedron whose faces meet in edges and corners. Round shapes are approximated
/// by chords, as only plane faces can be filled exactly.
///
/// Where corners, edges and faces lie on each other they do so to 1e-12 of the body's largest size, and
/// exactly along an axis to which a face is normal. Edges do not pass through corners or each other.
struct Complex {
  Box bounds{};
  double volume = 0;  ///< exact [m^3]
  std::vector<Point> corners;
  std::vector<Edge> edges;
  std::vector<Face> faces;             ///< of the surface
  std::vector<Face> inner_faces = {};  ///< between two materials
  /// Number of the material at a point; absent if there is only one.
  std::function<int(const Point&)> material = {};
  std::vector<double> material_volumes = {};        ///< exact [m^3]; empty if there is only one
  std::vector<std::array<int, 2>> interfaces = {};  ///< pairs of materials
  std::vector<SpacingRule> spacing_rules = {};
  std::vector<CrackStart> crack_starts;
  std::vector<Polygon> outline;  ///< in the y-z plane, for drawing
};

}  // namespace crackle::geometry
