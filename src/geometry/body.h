// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/complex.h"
#include "plane/side_index.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace crackle::geometry {

/// Location of a tetrahedron.
enum class Containment {
  inside,      ///< the body
  outside,     ///< its interior is outside the body
  straddling,  ///< neither: it crosses the surface or an inner face
};

/// Where a point lies: the number of a face, of an edge after those of all faces, or of a corner after those;
/// or one of the two below. Faces that continue an inner face across an edge in its plane count as that face.
using PlaceId = std::int32_t;
inline constexpr PlaceId in_interior = -1;
inline constexpr PlaceId out_of_body = -2;

/// The directions in which a point can move.
struct Directions {
  std::array<Vector, 3> vector{};  ///< the first n are orthonormal; those along axes come first, ascending
  int n = 0;

  /// Bit i is set if axis i is one of the directions, and further bits for others: as many as directions.
  std::uint8_t mask() const;
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

/// The exact geometry that every realization must fill. The thickness of a plate is along x and starts at 0;
/// its cracks are followed and drawn in the y-z plane.
///
/// The member functions agree without tolerance for the user: for a point that one of them returns (a corner,
/// on an edge, from `passage`, from `snapped`, the image of a point by a symmetry), a point from a face's
/// patch, and a point moved in its `directions`, `place_of` and `in_face` report the intended location.
/// Points on faces normal to an axis have exactly equal coordinates; others are on a face, on an edge or at a
/// corner within 1e-12 of the body's largest size. A grid finds what is near a point or a tetrahedron in a
/// time that does not depend on the number of faces.
class Body {
public:
  explicit Body(Complex complex);

  const Complex& complex() const { return complex_; }
  const Box& bounds() const { return complex_.bounds; }           ///< the bounding box of the body
  Point size() const { return bounds().upper - bounds().lower; }  ///< of that box [m]
  double volume() const { return complex_.volume; }               ///< exact [m^3]
  /// The points where edges meet; the Delaunay tetrahedra of any point set containing them fill the body's
  /// convex hull.
  const std::vector<Point>& corners() const { return complex_.corners; }
  const std::vector<Edge>& edges() const { return complex_.edges; }
  const std::vector<Face>& faces() const { return complex_.faces; }
  /// Plane facets inside the body, where two materials meet. They have no names, are meshed as the faces of
  /// the surface are, and continue their numbers: faces().size() is the first one's.
  const std::vector<Face>& inner_faces() const { return complex_.inner_faces; }
  /// Faces and inner faces.
  std::size_t n_meshed_faces() const { return faces().size() + inner_faces().size(); }
  const Face& meshed_face(FaceId id) const {
    const auto i = static_cast<std::size_t>(id);
    return i < faces().size() ? faces()[i] : inner_faces()[i - faces().size()];
  }
  /// Exact volume of each material [m^3], by its number; empty if the body has only one.
  const std::vector<double>& material_volumes() const { return complex_.material_volumes; }
  /// The crack starts; a crack that starts elsewhere belongs to none of them.
  const std::vector<CrackStart>& crack_starts() const { return complex_.crack_starts; }
  /// The body in the y-z plane, for drawing: its outer polygon counter-clockwise, then those of its holes.
  /// The first corner is not repeated.
  const std::vector<Polygon>& outline() const { return complex_.outline; }

  /// The faces with this name, ascending; may be empty.
  std::vector<FaceId> faces_named(const std::string& name) const;

  /// The face that contains all three corners; the first of several.
  /// @throws std::runtime_error when there is none
  FaceId face_of(const std::array<Point, 3>& corners) const;

  /// The pairs of materials whose boundary is an interface of the input, in its order.
  const std::vector<std::array<int, 2>>& interfaces() const { return complex_.interfaces; }
  /// Number of the material at a point; where several meet, one of them.
  int material_at(const Point& p) const { return complex_.material ? complex_.material(p) : 0; }

  PlaceId place_of(const Point& p) const;
  std::vector<PlaceId> places_of(std::span<const Point> points) const;
  /// The faces and inner faces that a place is on; of an inner face also those that continue it.
  std::span<const FaceId> faces_at(PlaceId place) const;
  /// The directions in which a point of the body can move without leaving its place.
  /// @pre place != out_of_body
  Directions directions(PlaceId place) const;
  /// The mask of these directions: 7 in the interior, 0 at a corner.
  std::uint8_t movable(const Point& p) const { return directions(place_of(p)).mask(); }
  /// True in the body and on its surface.
  bool contains(const Point& p) const { return place_of(p) != out_of_body; }
  /// True if a point lies on a face or its border.
  bool in_face(FaceId face, const Point& p) const;

  /// Distance from a point of the body to its surface or an inner face [m]; 0 outside.
  double distance_to_surface(const Point& p) const;
  /// Distance from a point of the face's patch to the border of the face or a line within it [m]; 0 outside.
  double distance_to_outline(FaceId face, const Point& p) const;
  /// The point where the segment between two points of the body crosses a face, or a line within the face if
  /// both lie in it; or the nearest point of an edge of the face if that is closer than `margin` [m].
  std::optional<Point> passage(FaceId face, const Point& p, const Point& q, double margin) const;
  /// The point itself, or the nearest corner, else the nearest point of an edge, else that of a face if not
  /// farther than `tolerance` [m].
  Point snapped(const Point& p, double tolerance) const;

  /// Exact, for any order of the corners. Called for each candidate tetrahedron. Those with all corners on
  /// one face are flat up to rounding and not part of the body.
  /// @param corners of a tetrahedron in the convex hull of the body
  Containment classify(const std::array<Point, 4>& corners) const;

  /// Distance of a point to the nearest of the faces that count, or `limit` if none is closer [m].
  double distance_to_faces(const Point& p, double limit, const std::function<bool(FaceId)>& counts) const;
  /// Ascending numbers of faces and inner faces that may meet a box, among others.
  std::vector<FaceId> faces_near(const Box& box) const;

  /// Places that require a finer mesh than the input's regions.
  std::vector<SpacingSource> spacing_sources(const input::Mesh& mesh) const;

  /// The reflections in the middles of the bounding box, also two or three at once, that map corners, edges,
  /// faces, materials and crack starts onto such, to the tolerance. In ascending order of their codes,
  /// starting with the identity.
  std::vector<Symmetry> symmetries() const;

private:
  /// A face with what is needed to locate points in it.
  struct Facet {
    Vector normal;
    Point origin;                           ///< in its plane
    int axis = -1;                          ///< to which it is normal, if any
    Point own_origin;                       ///< of its own coordinates
    std::array<Vector, 2> along;            ///< axes that span it
    plane::Bounds bounds{};                 ///< in own coordinates
    std::optional<plane::SideIndex> rim;    ///< `part` is the number of the edge, or -1
    std::optional<plane::SideIndex> lines;  ///< edges within the face
    std::vector<std::int32_t> points;       ///< corners within the face that end no edge
    FaceId first = 0;                       ///< of the inner faces that continue each other in one plane
    std::vector<FaceId> joined;             ///< these, of the first one

    double height(const Point& p) const { return dot(normal, p - origin); }
    plane::Point own(const Point& p) const {
      const Vector offset = p - own_origin;
      return {dot(offset, along[0]), dot(offset, along[1])};
    }
    bool holds(const plane::Point& own) const { return rim && rim->contains(own); }
    double distance_to_border(const plane::Point& own) const;
  };
  /// The faces that meet at an edge or a corner.
  struct Junction {
    std::vector<FaceId> faces;
    unsigned exact_axes = 0;  ///< bit i is set if one of the faces is normal to axis i
    bool is_crease = true;    ///< false if it only parts two inner faces in one plane
  };
  struct EdgeEnds {
    std::int32_t from = -1, to = -1;  ///< numbers of corners
  };
  using CellIndex = std::array<std::size_t, 3>;
  class Image;

  void add_facets();
  void make_grid();
  void join_edges();
  void join_corners();
  Point reference_of(const CellIndex& cell) const;
  bool meets(const Facet& facet, const CellIndex& cell) const;
  std::size_t n_between(std::span<const std::int32_t> facets, const Point& p, const Point& q) const;
  CellIndex cell_of(const Point& p) const;
  std::size_t number_of(const CellIndex& cell) const { return (cell[2] * n_[1] + cell[1]) * n_[0] + cell[0]; }
  std::span<const std::int32_t> facets_in(std::size_t cell) const {
    return {of_cell_.data() + first_[cell], of_cell_.data() + first_[cell + 1]};
  }
  bool is_in_plane(const Facet& facet, const Point& p) const {
    if (facet.axis >= 0) return p[index(facet.axis)] == facet.origin[index(facet.axis)];
    return std::abs(facet.height(p)) <= tolerance_;
  }
  bool is_at(const Junction& junction, const Point& there, const Point& p) const;
  bool is_inside(const Point& p) const;  ///< undefined on the surface
  double distance(const Facet& facet, const Point& p, double limit) const;
  bool crosses(const Facet& facet, const std::array<Point, 4>& corners,
               const std::array<double, 4>& height) const;
  PlaceId place_of_edge(std::size_t edge) const { return static_cast<PlaceId>(n_meshed_faces() + edge); }
  PlaceId place_of_corner(std::size_t corner) const {
    return static_cast<PlaceId>(n_meshed_faces() + edges().size() + corner);
  }

  Complex complex_;
  double tolerance_ = 0;  ///< [m]
  std::vector<Facet> facets_;
  std::vector<Junction> at_edge_, at_corner_;
  std::vector<EdgeEnds> ends_;
  // A grid of cells over the bounding box.
  Vector cell_size_{};
  CellIndex n_{};
  std::vector<std::int32_t> of_cell_;    ///< facets that meet it, cell by cell
  std::vector<std::size_t> first_;       ///< first entry of each cell in that list
  std::vector<std::uint8_t> is_inside_;  ///< of the reference point of each cell
};

/// The surface of the body described by an input, without its materials.
/// @throws std::runtime_error naming the error
std::unique_ptr<const Body> make_body(const plane::Specimen& specimen);

/// The same with the boundaries between its materials.
/// @throws std::runtime_error naming the error
std::unique_ptr<const Body> make_composite_body(const input::Model& model);

/// The same with the regions of the boundary conditions imprinted on its faces: the body to be meshed.
/// @throws std::runtime_error also when a region contains no part of its face
std::unique_ptr<const Body> make_body(const input::Model& model);

/// Its number of crack starts, `notches` in the shapes of the result files; without making the body.
std::size_t n_crack_starts(const input::Model& model);

}  // namespace crackle::geometry
