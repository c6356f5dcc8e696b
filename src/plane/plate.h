// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "common/real.h"
#include "common/vector.h"
#include "plane/shape.h"
#include "solid/solid.h"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// A body: a plate, which is a figure with a thickness, its slots, holes and parts of several materials; or
/// any solid. All values are in SI units.
namespace crackle::plane {

/// A face of the specimen's box; x is the thickness, y the width, z the length.
enum class Face : int { x_min, x_max, y_min, y_max, z_min, z_max };

inline constexpr std::array face_names{"x-min", "x-max", "y-min", "y-max", "z-min", "z-max"};

constexpr const char* name_of(Face face) {
  return face_names[index(face)];
}

/// The sides of a box as edges of an outline: edge-0 to edge-3, counter-clockwise.
inline constexpr std::array box_edges{Face::z_min, Face::y_max, Face::z_max, Face::y_min};

/// Axis of the normal: 0, 1 or 2.
constexpr int axis_of(Face face) {
  return static_cast<int>(face) / 2;
}

/// True for the face at the upper end of its axis.
constexpr bool is_upper(Face face) {
  return static_cast<int>(face) % 2 == 1;
}

/// The axis in the y-z plane along which a notch in this face is positioned.
constexpr int position_axis(Face face) {
  return axis_of(face) == 1 ? 2 : 1;
}

/// Closed intervals of x, y and z [m]; infinite if a coordinate is unbounded.
using Region = std::array<std::pair<double, double>, 3>;
inline constexpr std::pair<double, double> unbounded{-infinity, infinity};
inline constexpr Region everywhere{unbounded, unbounded, unbounded};

/// Shape of a slot's end in the body.
enum class SlotEnd {
  square,
  round,  ///< a half circle that touches the end point from inside
};

/// A slot between two points in the plane of the plate. An end on the surface or outside is open.
struct Slot {
  Point from{};  ///< y and z [m]
  Point to{};
  SlotEnd end = SlotEnd::square;
};

/// A slot through the whole thickness: cut into one of the faces y-min, y-max, z-min or z-max, or between two
/// points.
struct Notch {
  Face face = Face::y_min;
  double at = 0;                  ///< mid-plane of the slot along the face's other in-plane axis [m]
  double depth = 0;               ///< [m]
  double height = 0;              ///< opening of the slot [m]
  std::optional<Slot> slot = {};  ///< instead of face, at and depth
};

/// A hole through the whole thickness: a circle, an ellipse or a polygon.
struct Hole {
  Point center{};     ///< y and z [m]
  Point semi_axes{};  ///< equal for a circle; 0 for a polygon [m]
  double angle = 0;   ///< of the first semi-axis, from y towards z [rad]
  Polygon polygon;    ///< counter-clockwise
};

/// A crack that is there before any load, closed: a plane figure in space, given in one of three ways. Parts
/// of it outside the body do not count.
struct PreCrack {
  std::optional<std::array<Point, 2>> line = {};  ///< through the thickness, between two points
  std::vector<Vector> polygon = {};               ///< corners in order [m]
  // An ellipse around a center, with its axes along geometry::across(normal): thus those across x, y or z are
  // ascending.
  Vector center{};    ///< [m]
  Point semi_axes{};  ///< [m]; 0: no ellipse
  Vector normal{};    ///< of any length
};

/// The outline of a plate that is not a box.
struct Outline {
  Polygon polygon;    ///< counter-clockwise; empty for a circle
  double radius = 0;  ///< of a circle around (radius, radius) [m]
};

/// A prism that consists of another material than the rest of the body.
struct MaterialRegion {
  std::string material;            ///< its name
  std::optional<Hole> shape = {};  ///< in the plane of the plate; empty: the box
  Region box = everywhere;         ///< its extent; with a shape, only x
  // Derived from these and the mesh spacings.
  int number = 0;        ///< of the material
  Polygon outline = {};  ///< in the plane of the plate, counter-clockwise, with curves as chords
};

struct Specimen {
  Vector size{};  ///< of the box, or of the bounding box of an outline or a solid [m]
  std::vector<Notch> notches;
  std::optional<Outline> outline = {};
  std::vector<Hole> holes = {};
  std::vector<PreCrack> cracks = {};
  std::vector<MaterialRegion> regions = {};  ///< of several, the last one that contains a point counts
  /// For a body other than a box with slots cut into its faces: its shape in the plane of the plate, with
  /// curves as chords. Derived from the other members and the mesh spacings.
  std::optional<Shape> shape = {};
  std::shared_ptr<const solid::Solid> solid = {};  ///< instead of a plate
  std::string solid_file = {};                     ///< its name
};

/// True for a box with at most slots cut into its faces.
bool is_box(const Specimen& specimen);

/// The shape of a body in the plane of the plate. The parts of a box are edge-0 to edge-3 (box_edges) and
/// notch-0 and so on, its corners have the coordinates of its faces and slots without rounding.
/// @pre !specimen.solid
/// @throws std::runtime_error unless every notch of a box is a slot inside its face, apart from others
Shape shape_of(const Specimen& specimen);

/// The bounding box of the body. A plate starts at x = 0.
Region bounds_of(const Specimen& specimen);

/// The closed intervals of x, y and z removed by a slot in a face of the body's bounding box.
Region slot_of(const Notch& notch, const Region& bounds);

/// True if two slots of a box overlap, or come as close as `near` [m] along each axis.
bool meet(const Region& slot, const Region& other, const Vector& near);

/// End of the straight extension of a slot in a face of a box: at the opposite face, or at another slot
/// before it; as the coordinate along the axis of its depth [m].
double ligament_end(const Specimen& specimen, std::size_t i);

}  // namespace crackle::plane
