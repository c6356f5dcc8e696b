// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/index.h"
#include "plane/shape.h"
#include "plane/subdivision.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_2_algorithms.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace crackle::plane {

namespace {

/// Corners this close are one, relative to the largest coordinate.
constexpr double rounding = 1e-13;

double tolerance_of(const Shape& shape, const Polygon& other) {
  double largest = 0;
  const auto include = [&](const Polygon& corners) {
    for (const Point& p : corners) largest = std::max({largest, std::abs(p[0]), std::abs(p[1])});
  };
  for (const Loop& loop : shape.loops) include(loop.corners);
  include(other);
  return rounding * largest;
}

/// A side of what is left, which lies to its left.
struct Side {
  int from, to;
  int part;
};

/// What is left of a shape beside a cutter.
class Remainder {
public:
  Remainder(const Shape& shape, const Loop& cutter)
      : tolerance_(tolerance_of(shape, cutter.corners)),
        divided_(subdivide(shape, {cutter.corners}, tolerance_)) {
    std::vector<int> part_of_side;
    for (const Loop& loop : shape.loops)
      part_of_side.insert(part_of_side.end(), loop.part.begin(), loop.part.end());
    for (const auto& line : divided_.lines) {
      const bool is_cut_left = !line.left.empty(), is_cut_right = !line.right.empty();
      if (line.side >= 0 && !is_cut_left)
        add({line.end[0], line.end[1], part_of_side[index(line.side)]});
      else if (line.side < 0 && is_cut_left != is_cut_right)
        add({line.end[is_cut_left ? 1 : 0], line.end[is_cut_left ? 0 : 1], part_of(line.end, cutter)});
    }
  }

  /// The closed lines of sides, each from its first corner on.
  std::vector<Loop> loops() {
    std::vector<Loop> result;
    while (!sides_.empty()) {
      Loop& loop = result.emplace_back();
      const int start = sides_.begin()->first;
      Side side = take(sides_.begin()->second.front());
      for (;; side = take(next(side))) {
        loop.corners.push_back(divided_.corners[index(side.from)]);
        loop.part.push_back(side.part);
        if (side.to == start) break;
      }
    }
    return result;
  }

private:
  void add(const Side& side) { sides_[side.from].push_back(side); }

  Side take(Side side) {
    auto& here = sides_.at(side.from);
    std::erase_if(here, [&](const Side& other) { return other.to == side.to; });
    if (here.empty()) sides_.erase(side.from);
    return side;
  }

  /// Where pieces touch in a corner, the side that stays with the piece: the furthest to the left.
  Side next(const Side& side) const {
    const auto found = sides_.find(side.to);
    if (found == sides_.end()) throw std::logic_error("plane: what is left of a figure is not closed");
    const Point back = divided_.corners[index(side.from)] - divided_.corners[index(side.to)];
    return *std::ranges::max_element(found->second, {}, [&](const Side& other) {
      const Point along = divided_.corners[index(other.to)] - divided_.corners[index(other.from)];
      return std::atan2(-cross(along, back), -dot(along, back));
    });
  }

  int part_of(const std::array<int, 2>& end, const Loop& cutter) const {
    const Point& from = divided_.corners[index(end[0])];
    const Point& to = divided_.corners[index(end[1])];
    for (std::size_t i = 0; i < cutter.size(); ++i)
      if (distance(from, cutter.from(i), cutter.to(i)) <= 2 * tolerance_ &&
          distance(to, cutter.from(i), cutter.to(i)) <= 2 * tolerance_)
        return cutter.part[i];
    throw std::logic_error("plane: a side lies on none of those that it was cut from");
  }

  double tolerance_;
  Subdivision divided_;
  std::map<int, std::vector<Side>> sides_;  ///< by their first corner
};

}  // namespace

bool is_simple(const Polygon& polygon) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  std::vector<Kernel::Point_2> corners;
  for (const Point& p : polygon) corners.emplace_back(p[0], p[1]);
  return corners.size() >= 3 && CGAL::is_simple_2(corners.begin(), corners.end(), Kernel());
}

std::vector<Shape> difference(const Shape& shape, const Loop& cutter) {
  std::vector<Shape> pieces;
  std::vector<Loop> holes;
  for (Loop& loop : Remainder(shape, cutter).loops()) {
    if (signed_area(loop.corners) > 0)
      pieces.push_back({{std::move(loop)}, shape.parts});
    else
      holes.push_back(std::move(loop));
  }
  for (Loop& hole : holes)
    for (Shape& piece : pieces) {
      const Polygon& outline = piece.loops.front().corners;
      if (!std::ranges::any_of(hole.corners, [&](const Point& p) { return holds(outline, p); })) continue;
      piece.loops.push_back(std::move(hole));
      break;
    }
  return pieces;
}

double common_area(const Shape& shape, const Polygon& other) {
  double common = area(shape);
  for (const Shape& rest : difference(shape, {other, std::vector<int>(other.size(), 0)}))
    common -= area(rest);
  return common;
}

}  // namespace crackle::plane
