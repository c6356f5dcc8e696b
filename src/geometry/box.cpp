// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/box.h"

#include <cmath>

namespace crackle::geometry {

std::size_t longest_axis(const Box& box) {
  const Point size = box.upper - box.lower;
  return static_cast<std::size_t>(std::ranges::max_element(size) - size.begin());
}

std::array<Point, 8> corners_of(const Box& box) {
  std::array<Point, 8> corners{};
  for (unsigned corner = 0; corner < 8; ++corner)
    for (std::size_t i = 0; i < 3; ++i) corners[corner][i] = (corner >> i) & 1u ? box.upper[i] : box.lower[i];
  return corners;
}

double distance(const Point& p, const Box& box) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double gap = std::max({box.lower[i] - p[i], p[i] - box.upper[i], 0.0});
    sum += gap * gap;
  }
  return std::sqrt(sum);
}

double distance(const Box& a, const Box& b) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double gap = std::max({a.lower[i] - b.upper[i], b.lower[i] - a.upper[i], 0.0});
    sum += gap * gap;
  }
  return std::sqrt(sum);
}

}  // namespace crackle::geometry
