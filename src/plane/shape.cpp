// SPDX-License-Identifier: GPL-3.0-or-later
#include "plane/shape.h"

#include "common/index.h"
#include "common/real.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace crackle::plane {

double norm(const Point& a) {
  return std::sqrt(dot(a, a));
}

Bounds bounds_of(const Polygon& corners) {
  Bounds bounds{{infinity, infinity}, {-infinity, -infinity}};
  for (const Point& p : corners)
    for (std::size_t i = 0; i < 2; ++i) {
      bounds.lower[i] = std::min(bounds.lower[i], p[i]);
      bounds.upper[i] = std::max(bounds.upper[i], p[i]);
    }
  return bounds;
}

std::vector<std::string> names_of_side(const Shape& shape, std::size_t loop, std::size_t side) {
  const Loop& own = shape.loops[loop];
  std::vector<std::string> names{shape.parts[static_cast<std::size_t>(own.part[side])].name};
  if (loop != 0) return names;
  const Bounds bounds = bounds_of(own.corners);
  for (std::size_t axis = 0; axis < 2; ++axis)
    for (const bool is_upper : {false, true}) {
      const double end = is_upper ? bounds.upper[axis] : bounds.lower[axis];
      const auto is_at_end = [&](std::size_t i) {
        return own.from(i)[axis] == end && own.to(i)[axis] == end;
      };
      const auto touches_end = [&](std::size_t i) {
        return shape.parts[static_cast<std::size_t>(own.part[i])].is_curve &&
               (own.from(i)[axis] == end || own.to(i)[axis] == end);
      };
      bool is_flat = false;
      for (std::size_t i = 0; i < own.size(); ++i) is_flat = is_flat || is_at_end(i);
      if (is_flat ? is_at_end(side) : touches_end(side))
        names.push_back(std::string(axis == 0 ? "y" : "z") + (is_upper ? "-max" : "-min"));
    }
  return names;
}

bool holds(const Polygon& polygon, const Point& p) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    if (ray_meets(p, polygon[i], polygon[(i + 1) % polygon.size()])) inside = !inside;
  return inside;
}

double signed_area(const Polygon& corners) {
  // Relative to the first corner, which preserves the digits of a small polygon far from the origin.
  double twice = 0;
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    twice += cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  return twice / 2;
}

double area(const Shape& shape) {
  double sum = 0;
  for (const Loop& loop : shape.loops) sum += signed_area(loop.corners);
  return sum;
}

double distance(const Point& p, const Point& from, const Point& to) {
  const Point along = to - from;
  const double squared = dot(along, along);
  const double share = squared > 0 ? std::clamp(dot(p - from, along) / squared, 0.0, 1.0) : 0;
  return norm(p - (from + share * along));
}

double distance(const Point& from, const Point& to, const Point& other_from, const Point& other_to) {
  const Point along = to - from;
  const Point other_along = other_to - other_from;
  const auto parts = [](const Point& line, const Point& start, const Point& a, const Point& b) {
    return cross(line, a - start) * cross(line, b - start) < 0;
  };
  if (parts(along, from, other_from, other_to) && parts(other_along, other_from, from, to)) return 0;
  return std::min({distance(from, other_from, other_to), distance(to, other_from, other_to),
                   distance(other_from, from, to), distance(other_to, from, to)});
}

namespace {

/// The point of the ellipse at the angle whose half has the tangent t.
Point on_ellipse(const Point& centre, const Point& first, const Point& second, double t) {
  const double scale = 1 / (1 + t * t);
  return centre + (1 - t * t) * scale * first + 2 * t * scale * second;
}

/// Tangent of the half of 45 degrees.
const double middle = std::sqrt(2.0) - 1;

/// The corners of an ellipse from angle 0 to 45 degrees, with axes as long as the semi-axes, excluding the
/// end.
Polygon half_quarter(const Point& centre, const Point& first, const Point& second, const Spacing& spacing) {
  // The number of spacings up to equidistant parameters.
  constexpr std::size_t n_steps = 2048;
  const auto at = [&](double step) {
    return on_ellipse(centre, first, second, middle * step / static_cast<double>(n_steps));
  };
  std::vector<double> count(n_steps + 1, 0);
  Point before = centre + first;
  for (std::size_t i = 0; i < n_steps; ++i) {
    const Point after = at(static_cast<double>(i + 1));
    count[i + 1] = count[i] + norm(after - before) / spacing(before + 0.5 * (after - before));
    before = after;
  }
  const double n_chords = std::clamp(std::ceil(count.back() * (1 - 1e-9)), 1.0, max_chords);
  Polygon corners{centre + first};
  for (double chord = 1; chord < n_chords; ++chord) {
    const double wanted = count.back() * chord / n_chords;
    const auto i = static_cast<std::size_t>(std::ranges::upper_bound(count, wanted) - count.begin()) - 1;
    corners.push_back(at(static_cast<double>(i) + (wanted - count[i]) / (count[i + 1] - count[i])));
  }
  return corners;
}

/// The corners of a quarter of an ellipse excluding its end, symmetric about its middle, so that reflections
/// map circles onto themselves.
Polygon quarter(const Point& centre, const Point& first, const Point& second, const Spacing& spacing) {
  Polygon corners = half_quarter(centre, first, second, spacing);
  corners.push_back(on_ellipse(centre, first, second, middle));
  const Polygon other = half_quarter(centre, second, first, spacing);
  corners.insert(corners.end(), other.rbegin(), other.rend() - 1);
  return corners;
}

/// True if two boxes are farther apart than `limit` along an axis.
bool are_apart(const Bounds& a, const Bounds& b, double limit) {
  for (std::size_t i = 0; i < 2; ++i)
    if (a.lower[i] > b.upper[i] + limit || b.lower[i] > a.upper[i] + limit) return true;
  return false;
}

struct BoundedSide {
  Point from, to;
  Bounds bounds;
  std::size_t loop, side;
};

std::vector<BoundedSide> sides_of(const Loop& loop, std::size_t number) {
  std::vector<BoundedSide> sides;
  for (std::size_t i = 0; i < loop.size(); ++i)
    sides.push_back({loop.from(i), loop.to(i), bounds_of({loop.from(i), loop.to(i)}), number, i});
  return sides;
}

}  // namespace

Polygon arc(const Point& centre, const Point& first, const Point& second, int n_quarters,
            const Spacing& spacing) {
  Polygon corners;
  Point a = first;
  Point b = second;
  for (int i = 0; i < n_quarters; ++i) {
    const Polygon some = quarter(centre, a, b, spacing);
    corners.insert(corners.end(), some.begin(), some.end());
    const Point turned = -1.0 * a;
    a = b;
    b = turned;
  }
  if (n_quarters < 4) corners.push_back(centre + a);
  return corners;
}

std::optional<Gap> smallest_gap(const Shape& shape, double limit) {
  std::vector<BoundedSide> sides;
  for (std::size_t l = 0; l < shape.loops.size(); ++l)
    for (const BoundedSide& side : sides_of(shape.loops[l], l)) sides.push_back(side);
  std::optional<Gap> smallest;
  for (std::size_t i = 0; i < sides.size(); ++i)
    for (std::size_t j = i + 1; j < sides.size(); ++j) {
      const BoundedSide& a = sides[i];
      const BoundedSide& b = sides[j];
      if (are_apart(a.bounds, b.bounds, limit)) continue;
      const Loop& loop = shape.loops[a.loop];
      const int part = loop.part[a.side];
      if (a.loop == b.loop && (b.side == a.side + 1 || (b.side + 1) % loop.size() == a.side)) continue;
      if (part == shape.loops[b.loop].part[b.side] && shape.parts[static_cast<std::size_t>(part)].is_curve)
        continue;
      const double gap = distance(a.from, a.to, b.from, b.to);
      if (gap < (smallest ? smallest->distance : limit)) smallest = Gap{gap, a.loop, a.side, b.loop, b.side};
    }
  return smallest;
}

bool come_near(const Polygon& a, const Polygon& b, double limit) {
  if (are_apart(bounds_of(a), bounds_of(b), limit)) return false;
  const std::vector<BoundedSide> others = sides_of({b, {}}, 0);
  for (const BoundedSide& side : sides_of({a, {}}, 0))
    for (const BoundedSide& other : others)
      if (!are_apart(side.bounds, other.bounds, limit) &&
          distance(side.from, side.to, other.from, other.to) <= limit)
        return true;
  return false;
}

Corner sharpest_corner(const Shape& shape) {
  Corner sharpest{2 * std::numbers::pi, {}};
  for (const Loop& loop : shape.loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Point& place = loop.to(i);
      const Point back = loop.from(i) - place;
      const Point ahead = loop.to((i + 1) % loop.size()) - place;
      double angle = std::atan2(cross(ahead, back), dot(ahead, back));
      if (angle < 0) angle += 2 * std::numbers::pi;
      if (angle < sharpest.angle) sharpest = {angle, place};
    }
  return sharpest;
}

ChordApproximation chord_approximation(const Shape& shape, const std::string& part, const Point& centre,
                                       const Point& semi_axes, double angle) {
  const Point along{std::cos(angle), std::sin(angle)};
  ChordApproximation found;
  double area = 0;
  for (const Loop& loop : shape.loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      if (shape.parts[index(loop.part[i])].name != part) continue;
      const Point from = loop.from(i) - centre;
      const Point to = loop.to(i) - centre;
      const Point middle{(from[0] + to[0]) / 2, (from[1] + to[1]) / 2};
      ++found.n_chords;
      found.longest = std::max(found.longest, norm(to - from));
      found.inside = std::max(
          found.inside, 1 - norm({dot(middle, along) / semi_axes[0], cross(along, middle) / semi_axes[1]}));
      area += cross(from, to) / 2;
    }
  found.area = std::abs(area) / (std::numbers::pi * semi_axes[0] * semi_axes[1]);
  return found;
}

}  // namespace crackle::plane
