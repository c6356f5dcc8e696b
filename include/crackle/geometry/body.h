// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/index.h"
#include "crackle/common/real.h"
#include "crackle/common/vector.h"
#include "crackle/geometry/box.h"
#include "crackle/geometry/point.h"
#include "crackle/input/parameters.h"
#include "crackle/plane/shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
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

/// A plane facet of the body's surface.
struct Face {
  /// Names in boundary conditions, which several faces may share; the first one is for messages.
  std::vector<std::string> names;
  double area;     ///< exact [m^2]
  Vector outward;  ///< unit normal
  Patch patch;     ///< a rectangle that contains the face
};

/// A straight edge of the body between two of its corners.
class Edge {
public:
  Edge(const Point& from, const Point& to);
  const Point& from() const { return from_; }
  const Point& to() const { return to_; }
  double length() const { return length_; }  ///< [m]
  Point at(double length) const;             ///< the point at this distance from its start
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

  double at(const Point& p) const;            ///< the required spacing at a point [m]
  double lower_bound(const Box& part) const;  ///< over a part of the body [m]
  double upper_bound(const Box& part) const;  ///< likewise
};

/// Growth away from places where the body's shape, not the input, requires a fine spacing.
inline double shape_growth(const input::Mesh& mesh) {
  return std::max(mesh.growth, 0.2);
}

/// Location of a tetrahedron.
enum class Containment {
  inside,      ///< the body
  outside,     ///< its interior is outside the body
  straddling,  ///< neither: it crosses the surface or an inner face
};

/// The directions in which a point can move.
struct Directions {
  std::array<Vector, 3> vector;  ///< the first n are orthonormal
  int n;
};

/// A symmetry map of the body onto itself.
struct Symmetry {
  std::uint8_t code;   ///< identifies it among the body's symmetries; 0 for the identity
  std::string name;    ///< for messages, such as "reflected in the middle of y"
  bool is_reflection;  ///< true if it reverses handedness
  std::function<Point(const Point&)> image;
  std::function<Point(const Point&)> preimage;
  std::vector<std::int32_t> crack_start;  ///< the image of each crack start
};

using plane::Polygon;

/// The exact geometry that every realization must fill: a polyhedron, accessed only through this interface.
/// Round shapes are approximated by chords, as only plane faces can be filled exactly. The thickness is along
/// x and starts at 0; cracks are followed and drawn in the y-z plane.
///
/// The member functions must be mutually consistent without tolerance: for a point that one of them returns
/// (a corner, on an edge, from `passage`, from `snapped`, the image of a point by a symmetry), a point from a
/// face's patch, and a point moved in its `directions` and still in the body, `contains`, `movable` and
/// `in_face` must report the intended location. On planes x, y or z = const this only requires equal
/// coordinates; other planes require a tolerance within the implementation.
class Body {
public:
  virtual ~Body() = default;

  const Box& bounds() const { return shape_.bounds; }                       ///< the bounding box of the body
  Point size() const { return shape_.bounds.upper - shape_.bounds.lower; }  ///< of that box [m]
  double volume() const { return shape_.volume; }                           ///< exact [m^3]
  /// The points where edges meet; the Delaunay tetrahedra of any point set containing them fill the body's
  /// convex hull.
  const std::vector<Point>& corners() const { return shape_.corners; }
  const std::vector<Edge>& edges() const { return shape_.edges; }
  const std::vector<Face>& faces() const { return shape_.faces; }
  /// Plane facets inside the body, where two materials meet. They have no names, are meshed as the faces of
  /// the surface are, and continue their numbers: faces().size() is the first one's.
  const std::vector<Face>& inner_faces() const { return shape_.inner_faces; }
  /// Faces and inner faces.
  std::size_t n_meshed_faces() const { return faces().size() + inner_faces().size(); }
  const Face& meshed_face(FaceId id) const {
    const auto i = static_cast<std::size_t>(id);
    return i < faces().size() ? faces()[i] : inner_faces()[i - faces().size()];
  }
  /// Exact volume of each material [m^3], by its number; empty if the body has only one.
  const std::vector<double>& material_volumes() const { return shape_.material_volumes; }
  /// The crack starts; a crack that starts elsewhere belongs to none of them.
  const std::vector<CrackStart>& crack_starts() const { return shape_.crack_starts; }
  /// The body in the y-z plane, for drawing: its outer polygon counter-clockwise, then those of its holes.
  /// The first corner is not repeated.
  const std::vector<Polygon>& outline() const { return shape_.outline; }

  /// The faces with this name, ascending; may be empty.
  std::vector<FaceId> faces_named(const std::string& name) const;

  /// The face that contains all three corners; the first of several.
  /// @throws std::runtime_error when there is none
  FaceId face_of(const std::array<Point, 3>& corners) const;

  /// The pairs of materials whose boundary is an interface of the input, in its order.
  const std::vector<std::array<int, 2>>& interfaces() const { return shape_.interfaces; }
  /// Number of the material at a point; where several meet, one of them.
  virtual int material_at(const Point&) const { return 0; }

  /// True in the body and on its surface.
  virtual bool contains(const Point& p) const = 0;
  /// True if a point lies in the plane of a face and within its patch.
  virtual bool in_face(FaceId face, const Point& p) const = 0;

  /// The directions in which a point of the body can move without leaving its faces, inner ones included, as
  /// a bit mask with as many bits set as there are directions: 3 in the interior, 2 in a face, 1 on an edge,
  /// none at a corner. Bit i is set if axis i is one of the directions, further bits stand for others. Hence
  /// 7 in the interior.
  /// @pre contains(p)
  virtual std::uint8_t movable(const Point& p) const = 0;
  /// These directions.
  /// @pre movable(p) == movable
  virtual Directions directions(const Point& p, std::uint8_t movable) const = 0;

  /// Distance from a point of the body to its surface or an inner face [m].
  virtual double distance_to_surface(const Point& p) const = 0;
  /// Distance from a point of the face's patch to the outline of the face [m]; 0 or less outside the face.
  virtual double distance_to_outline(FaceId face, const Point& p) const = 0;
  /// The point where the segment between two points of the body crosses a face, or the nearest point of the
  /// face's outline if that is closer than `margin` [m].
  virtual std::optional<Point> passage(FaceId face, const Point& p, const Point& q, double margin) const = 0;
  /// The point itself, or the nearest point of the surface if not farther than `tolerance` [m]: on an edge or
  /// at a corner if all its faces are within the tolerance.
  virtual Point snapped(const Point& p, double tolerance) const = 0;

  /// Exact, for any order of the corners. Called for each candidate tetrahedron.
  /// @param corners of a tetrahedron in the convex hull of the body
  virtual Containment classify(const std::array<Point, 4>& corners) const = 0;

  /// Places that require a finer mesh than the input's regions.
  virtual std::vector<SpacingSource> spacing_sources(const input::Mesh& mesh) const = 0;

  /// In ascending order of their codes, starting with the identity. Each maps faces onto faces and crack
  /// starts onto crack starts.
  virtual std::vector<Symmetry> symmetries() const = 0;

protected:
  /// Data of an instance, fixed on construction.
  struct Shape {
    Box bounds{};
    double volume = 0;
    std::vector<Point> corners;
    std::vector<Edge> edges;
    std::vector<Face> faces;
    std::vector<Face> inner_faces = {};
    std::vector<double> material_volumes = {};
    std::vector<std::array<int, 2>> interfaces = {};
    std::vector<CrackStart> crack_starts;
    std::vector<Polygon> outline;
  };
  Body() = default;
  Body(const Body&) = default;
  Body& operator=(const Body&) = default;

  Shape shape_;
};

/// The surface of the body described by an input, without its materials.
/// @throws std::runtime_error naming the error
std::unique_ptr<const Body> make_body(const input::Specimen& specimen);

/// The same with the boundaries between its materials.
/// @throws std::runtime_error naming the error
std::unique_ptr<const Body> make_composite_body(const input::Parameters& parameters);

/// The same with the regions of the boundary conditions imprinted on its faces: the body to be meshed.
/// @throws std::runtime_error also when a region contains no part of its face
std::unique_ptr<const Body> make_body(const input::Parameters& parameters);

/// Its number of crack starts, `notches` in the shapes of the result files; without making the body.
std::size_t n_crack_starts(const input::Specimen& specimen);

}  // namespace crackle::geometry
