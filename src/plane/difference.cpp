// SPDX-License-Identifier: GPL-3.0-or-later
// Set operations, by CGAL in exact arithmetic.
#include "crackle/plane/shape.h"

#include <CGAL/Boolean_set_operations_2.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Polygon_with_holes_2.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

namespace crackle::plane {

namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using ExactPolygon = CGAL::Polygon_2<Kernel>;
using ExactShape = CGAL::Polygon_with_holes_2<Kernel>;

/// Rounding of corners, relative to the largest coordinate.
constexpr double rounding = 1e-13;

ExactPolygon exact(const Polygon& polygon) {
  ExactPolygon result;
  for (const Point& p : polygon) result.push_back(Kernel::Point_2(p[0], p[1]));
  return result;
}

ExactShape exact(const Shape& shape) {
  ExactShape result(exact(shape.loops.front().corners));
  for (std::size_t i = 1; i < shape.loops.size(); ++i) result.add_hole(exact(shape.loops[i].corners));
  return result;
}

Polygon rounded(const ExactPolygon& polygon) {
  Polygon result;
  for (const auto& p : polygon.container()) {
    const Point corner{CGAL::to_double(p.x()), CGAL::to_double(p.y())};
    if (result.empty() || corner != result.back()) result.push_back(corner);
  }
  if (result.size() > 1 && result.front() == result.back()) result.pop_back();
  return result;
}

/// Assigns to the sides of new polygons the parts of the old sides on which they lie.
class Parts {
public:
  Parts(const Shape& shape, const Loop& cutter) : loops_(shape.loops) {
    loops_.push_back(cutter);
    double largest = 0;
    for (const Loop& loop : loops_)
      for (const Point& p : loop.corners) largest = std::max({largest, std::abs(p[0]), std::abs(p[1])});
    near_ = rounding * largest;
  }

  Loop labelled(const Polygon& polygon) const {
    Loop result;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Point& from = polygon[i];
      const Point& to = polygon[(i + 1) % polygon.size()];
      std::vector<Point> corners = corners_between(from, to);
      corners.insert(corners.begin(), from);
      for (std::size_t k = 0; k < corners.size(); ++k) {
        result.corners.push_back(corners[k]);
        result.part.push_back(part_of(corners[k], k + 1 < corners.size() ? corners[k + 1] : to));
      }
    }
    return result;
  }

private:
  /// The old corners on a side, in order.
  std::vector<Point> corners_between(const Point& from, const Point& to) const {
    std::vector<Point> found;
    const double length = norm(to - from);
    for (const Loop& loop : loops_)
      for (const Point& p : loop.corners) {
        const double way = dot(p - from, to - from) / length;
        if (way > near_ && way < length - near_ && distance(p, from, to) <= near_) found.push_back(p);
      }
    std::ranges::sort(found, {}, [&](const Point& p) { return dot(p - from, to - from); });
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  int part_of(const Point& from, const Point& to) const {
    for (const Loop& loop : loops_)
      for (std::size_t i = 0; i < loop.size(); ++i)
        if (distance(from, loop.from(i), loop.to(i)) <= near_ &&
            distance(to, loop.from(i), loop.to(i)) <= near_)
          return loop.part[i];
    throw std::logic_error("plane: a side lies on none of those that it was cut from");
  }

  std::vector<Loop> loops_;
  double near_;
};

}  // namespace

bool is_simple(const Polygon& polygon) {
  return polygon.size() >= 3 && exact(polygon).is_simple();
}

bool overlap(const Polygon& a, const Polygon& b) {
  const auto counter_clockwise = [](const Polygon& polygon) {
    ExactPolygon result = exact(polygon);
    if (result.is_clockwise_oriented()) result.reverse_orientation();
    return result;
  };
  return CGAL::do_intersect(counter_clockwise(a), counter_clockwise(b));
}

std::vector<Shape> difference(const Shape& shape, const Loop& cutter) {
  std::vector<ExactShape> pieces;
  CGAL::difference(exact(shape), exact(cutter.corners), std::back_inserter(pieces));
  const Parts parts(shape, cutter);
  std::vector<Shape> result;
  for (const ExactShape& piece : pieces) {
    Shape some{{parts.labelled(rounded(piece.outer_boundary()))}, shape.parts};
    for (const ExactPolygon& hole : piece.holes()) some.loops.push_back(parts.labelled(rounded(hole)));
    result.push_back(std::move(some));
  }
  return result;
}

}  // namespace crackle::plane
