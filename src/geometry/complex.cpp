// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/complex.h"

namespace crackle::geometry {

Point Patch::at(const Point& own) const {
  return origin + own[0] * axes[0] + own[1] * axes[1] + own[2] * axes[2];
}

Point Patch::own(const Point& p) const {
  const Vector offset = p - origin;
  return {dot(offset, axes[0]), dot(offset, axes[1]), dot(offset, axes[2])};
}

Box Patch::bounds(const Box& own) const {
  Box box{origin, origin};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax({own.lower[k] * axes[k][i], own.upper[k] * axes[k][i]});
      box.lower[i] += low;
      box.upper[i] += high;
    }
  return box;
}

std::array<std::size_t, 2> Face::spanning_axes() const {
  std::array<std::size_t, 2> axes{0, 1};
  std::size_t n = 0;
  for (std::size_t i = 0; i < 3 && n < 2; ++i)
    if (patch.domain.upper[i] > patch.domain.lower[i]) axes[n++] = i;
  return axes;
}

Edge::Edge(const Point& from, const Point& to)
    : from_(from), to_(to), length_(norm(to - from)), direction_((to - from) / length_) {}

Point Edge::at(double length) const {
  return from_ + length * direction_;
}

Point Edge::nearest(const Point& p) const {
  const double arc_length = dot(p - from_, direction_);
  if (arc_length <= 0) return from_;
  if (arc_length >= length_) return to_;
  Point result = at(arc_length);
  // Along an axis the coordinate is that of the point, without rounding.
  for (std::size_t i = 0; i < 3; ++i)
    if (std::abs(direction_[i]) == 1) result[i] = p[i];
  return result;
}

double Edge::distance(const Point& p) const {
  return norm(p - nearest(p));
}

Box Edge::bounds() const {
  Box box{from_, from_};
  box.include(to_);
  return box;
}

}  // namespace crackle::geometry
