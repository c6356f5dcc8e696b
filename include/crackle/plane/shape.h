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
/// Above 0 where b points to the left of a.
inline double cross(const Point& a, const Point& b) {
  return a[0] * b[1] - a[1] * b[0];
}
double norm(const Point& a);

/// A named piece of a boundary, such as one edge of an outline or the whole of a hole.
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

/// By which boundary conditions call a side: the name of its part and, where it lies at an end of the shape
/// along an axis, "y-min", "y-max", "z-min" or "z-max". Where a curve ends the shape, the chords that touch
/// the end have that name.
std::vector<std::string> names_of_side(const Shape& shape, std::size_t loop, std::size_t side);

/// The least box round the figure.
struct Bounds {
  Point lower;
  Point upper;
};
Bounds bounds_of(const Polygon& corners);

/// Above 0 for corners in counter-clockwise order [m^2].
double signed_area(const Polygon& corners);
double area(const Shape& shape);  ///< without the holes [m^2]

/// Whether the ray from a point along y meets a side: a point is inside where it meets an odd number of them.
/// Of no use on a side.
inline bool ray_meets(const Point& p, const Point& from, const Point& to) {
  return (from[1] > p[1]) != (to[1] > p[1]) &&
         from[0] + (p[1] - from[1]) / (to[1] - from[1]) * (to[0] - from[0]) > p[0];
}
/// Whether a point lies inside a polygon, and not on its sides.
bool holds(const Polygon& polygon, const Point& p);

/// Euclidean distances [m]; 0 where the sets meet.
double distance(const Point& p, const Point& from, const Point& to);
double distance(const Point& from, const Point& to, const Point& other_from, const Point& other_to);

/// The distance of neighbouring points that is wanted at a place [m].
using Spacing = std::function<double(const Point&)>;

/// Of an eighth of an ellipse.
inline constexpr double max_chords = 250;

/// Corners on a part of an ellipse, centre + cos(angle) first + sin(angle) second, from angle 0 over
/// `n_quarters` quarter turns; without the last one where these make a full turn. Each eighth is divided
/// into chords of the same length in local spacings, none longer than the spacing, unless
/// these are more than max_chords. Takes no more than square
/// roots, so every machine computes the same bits.
Polygon arc(const Point& centre, const Point& first, const Point& second, int n_quarters,
            const Spacing& spacing);

/// Whether no two sides meet but neighbours in their common corner. Exact.
bool is_simple(const Polygon& polygon);

/// What is left of a figure where another one is cut out: its connected pieces, none where nothing is left.
/// Exact but for the rounding of the corners that arise. Sides keep their parts and those of the cutter,
/// which are indices into the same list; corners of both stay corners.
/// @param cutter simple, counter-clockwise
std::vector<Shape> difference(const Shape& shape, const Loop& cutter);

/// Whether the interiors of two simple polygons meet. Exact.
bool overlap(const Polygon& a, const Polygon& b);

/// Two sides that belong together without being neighbours.
struct Gap {
  double distance;  ///< [m]
  std::size_t loop, side;
  std::size_t other_loop, other_side;
};

/// The sides of a shape that come nearest to each other without being neighbours, nor chords of the same
/// curve; nothing where all keep a distance of `limit` [m].
std::optional<Gap> smallest_gap(const Shape& shape, double limit);

/// Whether the sides of two polygons come as near to each other as `limit` [m]. Fast for those far apart.
bool come_near(const Polygon& a, const Polygon& b, double limit);

/// The smallest inner angle at the corners of a shape [rad], and where it is.
struct Corner {
  double angle;
  Point place;
};
Corner sharpest_corner(const Shape& shape);

}  // namespace crackle::plane
