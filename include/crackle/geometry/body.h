// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/box.h"
#include "crackle/geometry/crack_start.h"
#include "crackle/geometry/point.h"
#include "crackle/input/parameters.h"
#include "crackle/plane/shape.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace crackle::geometry {

/// A box that lies anywhere in space: a rectangle where it has no extent along one of its own axes.
struct Patch {
  Box domain;  ///< in its own coordinates [m]
  Point origin{};
  std::array<Vector, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< orthonormal

  Point at(const Point& own) const;  ///< the point with these own coordinates
  Point own(const Point& p) const;   ///< own coordinates of a point
  Box bounds(const Box& own) const;  ///< that holds a part of the domain
  Box bounds() const { return bounds(domain); }
};

/// A plane piece of the body's surface.
struct Face {
  /// By which messages and boundary conditions call it, its own first; several faces may share the others.
  std::vector<std::string> names;
  double area;     ///< exact [m^2]
  Vector outward;  ///< unit normal
  Patch patch;     ///< a rectangle that holds the face
};

/// A straight edge of the body between two of its corners.
class Edge {
public:
  Edge(const Point& from, const Point& to);
  const Point& from() const { return from_; }
  const Point& to() const { return to_; }
  double length() const { return length_; }  ///< [m]
  Point at(double length) const;             ///< the point this far from its start
  Box bounds() const;

private:
  Point from_, to_;
  double length_;
  Vector direction_;
};

/// Where a fine mesh is asked for: in a box or, where `wall` is given, on a wall through the whole thickness.
struct SpacingSource {
  Box region;                                            ///< that holds the wall, if any
  double spacing;                                        ///< at most, in the region [m]
  double growth;                                         ///< per distance from the region
  std::string reason;                                    ///< for messages, such as "the height of notch 1"
  std::optional<std::array<plane::Point, 2>> wall = {};  ///< its ends in the y-z plane

  double at(const Point& p) const;            ///< the spacing that is asked for at a point [m]
  double lower_bound(const Box& part) const;  ///< over a part of the body [m]
  double upper_bound(const Box& part) const;  ///< likewise
};

/// Growth away from places where the shape of the body, not the input, asks for a fine spacing.
inline double shape_growth(const input::Mesh& mesh) {
  return std::max(mesh.growth, 0.2);
}

/// Where a tetrahedron lies.
enum class Place {
  solid,     ///< in the body
  cavity,    ///< its interior is clear of the body
  crossing,  ///< neither: it reaches through the surface
};

/// The directions in which a point can move.
struct Directions {
  std::array<Vector, 3> vector;  ///< the first n are orthonormal
  int n;
};

/// A map of the body on itself.
struct Symmetry {
  std::uint8_t code;   ///< tells it from the body's others; 0 for the identity
  std::string name;    ///< for messages, such as "reflected in the middle of y"
  bool is_reflection;  ///< whether it turns a right hand into a left one
  std::function<Point(const Point&)> image;
  std::function<Point(const Point&)> preimage;
  std::vector<std::int32_t> crack_start;  ///< that each one is mapped on
};

using plane::Polygon;

/// The exact geometry that every realization must fill: a polyhedron, which the rest of the program sees
/// through these questions alone. A round shape is given by its chords, as only plane faces can be filled
/// exactly. The thickness is along x and begins at 0; cracks are followed
/// and drawn in the y-z plane.
///
/// The answers must agree with each other without tolerance where one uses the result of another: a point
/// that a question returns (a corner, on an edge, from `passage`, from `snapped`, the image of a point by a
/// symmetry), a point from a face's patch, and a point moved in its `directions` and still in the body, is
/// told by `contains`, `movable` and `in_face` to lie where it was put. On planes x, y or z = const that
/// takes no more than equal coordinates; other planes take a tolerance within the instance.
class Body {
public:
  virtual ~Body() = default;

  const Box& bounds() const { return shape_.bounds; }  ///< the smallest box round the body
  Point size() const { return shape_.bounds.upper - shape_.bounds.lower; }  ///< of that box [m]
  double volume() const { return shape_.volume; }                           ///< exact [m^3]
  /// Those where edges meet; Delaunay tetrahedra of points that have them all fill the body's convex hull.
  const std::vector<Point>& corners() const { return shape_.corners; }
  const std::vector<Edge>& edges() const { return shape_.edges; }
  const std::vector<Face>& faces() const { return shape_.faces; }
  /// Where cracks start; a crack that starts elsewhere belongs to none.
  const std::vector<CrackStart>& crack_starts() const { return shape_.crack_starts; }
  /// The body in the y-z plane, for drawing: its outer polygon counter-clockwise, then those of its holes. No
  /// polygon repeats its first corner.
  const std::vector<Polygon>& outline() const { return shape_.outline; }

  /// The faces of this name, ascending; none where no face has it.
  std::vector<FaceId> faces_named(const std::string& name) const;

  /// The face in which all three corners lie, the first of several.
  /// @throws std::runtime_error where there is none
  FaceId face_of(const std::array<Point, 3>& corners) const;

  /// True in the body and on its surface.
  virtual bool contains(const Point& p) const = 0;
  /// Whether a point lies in the plane of a face and within its patch.
  virtual bool in_face(FaceId face, const Point& p) const = 0;

  /// In which directions a point of the body can move without leaving its faces, with as many bits set as
  /// there are such directions: 3 in the interior, 2 in a face, 1 on an edge, none at a corner. Bit i is set
  /// where axis i is one of the directions, further bits stand for others. So the interior has 7.
  /// @pre contains(p)
  virtual std::uint8_t movable(const Point& p) const = 0;
  /// These directions.
  /// @pre movable(p) == movable
  virtual Directions directions(const Point& p, std::uint8_t movable) const = 0;

  /// Distance from a point of the body to its surface [m].
  virtual double distance_to_surface(const Point& p) const = 0;
  /// Distance from a point of the face's patch to the outline of the face [m]; 0 or less outside the face.
  virtual double distance_to_outline(FaceId face, const Point& p) const = 0;
  /// The point where the segment between two points of the body passes through a face from one side to the
  /// other, or the nearest one of the face's outline if that is nearer than `margin` [m].
  virtual std::optional<Point> passage(FaceId face, const Point& p, const Point& q, double margin) const = 0;
  /// The point itself, or the nearest one of the surface where that is not farther than `tolerance` [m]: of
  /// an edge or a corner where all its faces are that near.
  virtual Point snapped(const Point& p, double tolerance) const = 0;

  /// Exact, whatever the order of the corners. Asked for each tetrahedron that is tried.
  /// @param corners of a tetrahedron in the convex hull of the body
  virtual Place place(const std::array<Point, 4>& corners) const = 0;

  /// The places that ask for a finer mesh than the input's regions do.
  virtual std::vector<SpacingSource> spacing_sources(const input::Mesh& mesh) const = 0;

  /// In ascending order of their codes, the identity first. Each maps faces on faces and crack starts on
  /// crack starts.
  virtual std::vector<Symmetry> symmetries() const = 0;

protected:
  /// What an instance knows once it is made.
  struct Shape {
    Box bounds{};
    double volume = 0;
    std::vector<Point> corners;
    std::vector<Edge> edges;
    std::vector<Face> faces;
    std::vector<CrackStart> crack_starts;
    std::vector<Polygon> outline;
  };
  Body() = default;
  Body(const Body&) = default;
  Body& operator=(const Body&) = default;

  Shape shape_;
};

/// The body that an input describes.
/// @throws std::runtime_error naming what is wrong with it
std::unique_ptr<const Body> make_body(const input::Specimen& specimen);

/// The same with the regions of the boundary conditions imprinted on its faces: what is meshed.
/// @throws std::runtime_error also where a region holds no part of its face
std::unique_ptr<const Body> make_body(const input::Parameters& parameters);

/// Its number of crack starts, `notches` in the shapes of the result files.
std::size_t n_crack_starts(const input::Specimen& specimen);

}  // namespace crackle::geometry
