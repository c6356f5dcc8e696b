// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "plane/shape.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::plane {

/// A side of a figure, which lies to its left.
struct Side {
  Point from, to;
  Point along;    ///< unit vector
  double length;  ///< [m]
  int part;       ///< index into Shape::parts

  /// Distance of a point from the side's line [m], positive to the left.
  double height(const Point& p) const { return cross(along, p - from); }
  /// Coordinate of a point along the line [m].
  double arc_length(const Point& p) const { return dot(along, p - from); }
};

/// Location of the convex hull of some points.
enum class Cover {
  inside,    ///< in the figure
  outside,   ///< its interior is outside the figure, or all points lie on the line of one side
  crossing,  ///< neither
};

/// The point that divides a segment in this share of its length.
inline Point between(const Point& from, const Point& to, double share) {
  return from + share * (to - from);
}

Side side_between(const Point& from, const Point& to, int part);

/// The sides of a shape, loop by loop.
std::vector<Side> sides_of(const Shape& shape);

/// Finds the parts of a shape near a point, in a time independent of the number of sides. Points within the
/// tolerance of a side are on it. Among many holes Boost.Geometry's R-tree takes 4 to 14 times as long as
/// this grid.
class SideIndex {
public:
  SideIndex(const Shape& shape, double tolerance);
  /// Sides that may leave gaps: a point is inside if an odd number of them separates it from the outside.
  /// @param bounds where points are looked for, not flat; they contain the sides
  SideIndex(std::vector<Side> sides, const Bounds& bounds, double tolerance);

  const std::vector<Side>& sides() const { return sides_; }
  double tolerance() const { return tolerance_; }

  bool contains(const Point& p) const;  ///< in the figure or on a side
  /// To the nearest side, infinite without sides [m].
  /// @param limit larger distances are not exact: the result is then some value above it
  double distance(const Point& p, double limit = infinity) const;
  Cover cover(const std::array<Point, 4>& points) const;
  /// @param points at most 8
  Cover cover(std::span<const Point> points) const;

  /// Calls visit(number) for each side that the point is on.
  template <class Visit>
  void for_sides_at(const Point& p, Visit&& visit) const {
    for (const std::int32_t i : sides_in(cell_of(p)))
      if (is_on(sides_[static_cast<std::size_t>(i)], p)) visit(static_cast<std::size_t>(i));
  }

  bool is_on(const Side& side, const Point& p) const {
    const double arc_length = side.arc_length(p);
    const double height = side.height(p);
    return height <= tolerance_ && height >= -tolerance_ && arc_length >= -tolerance_ &&
           arc_length <= side.length + tolerance_;
  }

private:
  struct Cell {
    std::size_t column;
    std::size_t row;
  };

  Cell cell_of(const Point& p) const;
  std::span<const std::int32_t> sides_in(const Cell& cell) const {
    const std::size_t i = cell.row * n_[0] + cell.column;
    return {of_cell_.data() + first_[i], of_cell_.data() + first_[i + 1]};
  }
  bool contains_open(const Point& p) const;
  template <std::size_t extent>
  Cover cover_of(std::span<const Point, extent> points) const;

  std::vector<Side> sides_;
  double tolerance_;
  Bounds bounds_{};
  double cell_size_ = 0;
  std::array<std::size_t, 2> n_{};                 ///< cells along y and z
  std::vector<std::int32_t> of_cell_;              ///< sides, cell by cell
  std::vector<std::size_t> first_;                 ///< first entry of each cell in that list
  std::vector<std::uint8_t> is_inside_;            ///< of cells without sides
  std::vector<std::vector<std::int32_t>> of_row_;  ///< sides that intersect a row of cells
};

}  // namespace crackle::plane
