// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

/// Figures in the plane of the plate, bounded by straight sides.
namespace crackle::plane {

using Point = std::array<double, 2>;  ///< y and z [m]
using Polygon = std::vector<Point>;   ///< corners in order; the first one is not repeated

inline Point operator+(const Point& a, const Point& b) {
  return {a[0] + b[0], a[1] + b[1]};
}
inline Point operator-(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1]};
}
inline Point operator*(double factor, const Point& a) {
  return {factor * a[0], factor * a[1]};
}
inline double dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1];
}
/// Positive if b points to the left of a.
inline double cross(const Point& a, const Point& b) {
  return a[0] * b[1] - a[1] * b[0];
}
double norm(const Point& a);

/// A named part of a boundary, such as one edge of an outline or the whole of a hole.
struct Part {
  std::string name;
  bool is_curve = false;  ///< its sides are the chords of one closed curve
};

/// A closed line of sides. Side i runs from corner i to the next one and belongs to part[i].
struct Loop {
  Polygon corners;
  std::vector<int> part;  ///< indices into the shape's parts

  std::size_t size() const { return corners.size(); }
  const Point& from(std::size_t i) const { return corners[i]; }
  const Point& to(std::size_t i) const { return corners[(i + 1) % corners.size()]; }
};

/// A connected figure with holes. The figure is to the left of every side: the outline runs
/// counter-clockwise, holes clockwise.
struct Shape {
  std::vector<Loop> loops;  ///< the outline first
  std::vector<Part> parts;
};

/// Names of a side in boundary conditions: that of its part and, if it lies at an end of the shape along an
/// axis, "y-min", "y-max", "z-min" or "z-max". If a curve ends the shape, the chords that touch the end have
/// that name.
std::vector<std::string> names_of_side(const Shape& shape, std::size_t loop, std::size_t side);

/// The bounding box of the figure.
struct Bounds {
  Point lower;
  Point upper;
};
Bounds bounds_of(const Polygon& corners);

/// Positive for counter-clockwise corners [m^2].
double signed_area(const Polygon& corners);
double area(const Shape& shape);  ///< without the holes [m^2]

/// True if the ray from a point along y intersects a side: a point is inside if its ray intersects an odd
/// number of sides. Undefined on a side.
inline bool ray_meets(const Point& p, const Point& from, const Point& to) {
  return (from[1] > p[1]) != (to[1] > p[1]) &&
         from[0] + (p[1] - from[1]) / (to[1] - from[1]) * (to[0] - from[0]) > p[0];
}
/// True if a point lies strictly inside a polygon.
bool holds(const Polygon& polygon, const Point& p);

/// Euclidean distances [m]; 0 if the sets intersect. A segment's ends may coincide.
double distance(const Point& p, const Point& from, const Point& to);
double distance(const Point& from, const Point& to, const Point& other_from, const Point& other_to);

/// The required distance of neighbouring points at a place [m].
using Spacing = std::function<double(const Point&)>;

/// Per eighth of an ellipse.
inline constexpr double max_chords = 250;

/// Corners on a part of an ellipse, centre + cos(angle) first + sin(angle) second, from angle 0 over
/// `n_quarters` quarter turns; without the last one if these make a full turn. Each eighth is divided into
/// chords of equal length in local spacings, none longer than the spacing unless that requires more than
/// max_chords. Uses only square roots, so results are bitwise equal on every machine.
Polygon arc(const Point& centre, const Point& first, const Point& second, int n_quarters,
            const Spacing& spacing);

/// True if no two sides intersect, except neighbours in their common corner. Exact.
bool is_simple(const Polygon& polygon);

/// The connected pieces of a figure after cutting out another one; empty if nothing is left. Corners closer
/// than 1e-13 of the largest coordinate are one. Sides keep their parts and those of the cutter, which are
/// indices into the same list; corners of both are kept.
/// @param cutter simple, counter-clockwise
std::vector<Shape> difference(const Shape& shape, const Loop& cutter);

/// Two close sides that are not neighbours.
struct Gap {
  double distance;  ///< [m]
  std::size_t loop, side;
  std::size_t other_loop, other_side;
};

/// The closest two sides of a shape that are neither neighbours nor chords of the same curve; empty if all
/// are at least `limit` [m] apart.
std::optional<Gap> smallest_gap(const Shape& shape, double limit);

/// True if the sides of two polygons come closer than `limit` [m]. Fast for distant ones.
bool come_near(const Polygon& a, const Polygon& b, double limit);

/// The smallest interior angle at the corners of a shape [rad], and its location.
struct Corner {
  double angle;
  Point place;
};
Corner sharpest_corner(const Shape& shape);

/// How the chords of a shape's boundary approximate an ellipse.
struct ChordApproximation {
  int n_chords = 0;
  double longest = 0;  ///< [m]
  double inside = 0;   ///< largest distance of a chord's midpoint inside the curve, relative to the radius
  double area = 0;     ///< enclosed by the chords together with the centre, relative to the ellipse's
};

/// @param part name of the ellipse's part of the boundary
/// @param angle of the first semi-axis [rad]
ChordApproximation chord_approximation(const Shape& shape, const std::string& part, const Point& centre,
                                       const Point& semi_axes, double angle);

}  // namespace crackle::plane
