// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/quality.h"

#include "common/vector.h"

#include <cmath>

namespace crackle::geometry {

namespace {

double sum_of_squared_edges(const Point& u, const Point& v, const Point& w) {
  const Point uv = v - u;
  const Point uw = w - u;
  const Point vw = w - v;
  return dot(u, u) + dot(v, v) + dot(w, w) + dot(uv, uv) + dot(uw, uw) + dot(vw, vw);
}

}  // namespace

double signed_volume(const Point& a, const Point& b, const Point& c, const Point& d) {
  return dot(b - a, cross(c - a, d - a)) / 6;
}

double mean_ratio(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Point u = b - a;
  const Point v = c - a;
  const Point w = d - a;
  const double volume = dot(u, cross(v, w)) / 6;
  if (!(volume > 0)) return 0;
  const double root = std::cbrt(3 * volume);
  return 12 * root * root / sum_of_squared_edges(u, v, w);
}

double mean_ratio_cubed(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Point u = b - a;
  const Point v = c - a;
  const Point w = d - a;
  const double three_volumes = dot(u, cross(v, w)) / 2;
  const double sum = sum_of_squared_edges(u, v, w);
  return sum > 0 ? 1728 * three_volumes * three_volumes / (sum * sum * sum) : 0;
}

std::array<double, 6> dihedral_angles(const Point& a, const Point& b, const Point& c, const Point& d) {
  const std::array<Point, 4> corner{a, b, c, d};
  std::array<double, 6> angle{};
  std::size_t n = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      std::array<std::size_t, 2> other{};
      for (std::size_t k = 0, m = 0; k < 4; ++k)
        if (k != i && k != j) other[m++] = k;
      const Point axis = corner[j] - corner[i];
      const Point p = cross(axis, corner[other[0]] - corner[i]);
      const Point q = cross(axis, corner[other[1]] - corner[i]);
      angle[n++] = std::atan2(norm(cross(p, q)), dot(p, q));
    }
  }
  return angle;
}

}  // namespace crackle::geometry
