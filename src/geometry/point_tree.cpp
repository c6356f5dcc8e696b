// SPDX-License-Identifier: GPL-3.0-or-later
#include "point_tree.h"

#include "crackle/common/index.h"
#include "crackle/geometry/box.h"

#include <algorithm>
#include <numeric>

namespace crackle::geometry {

namespace {
constexpr std::size_t leaf_size = 8;
}

PointTree::PointTree(std::span<const Point> points)
    : points_(points), order_(points.size()), split_axis_(points.size(), 0) {
  std::iota(order_.begin(), order_.end(), 0);
  build(0, order_.size());
}

void PointTree::build(std::size_t begin, std::size_t end) {
  if (end - begin <= leaf_size) return;
  Box box = nowhere;
  for (std::size_t i = begin; i < end; ++i) box.include(points_[index(order_[i])]);
  const std::size_t widest = longest_axis(box);
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](std::int32_t a, std::int32_t b) {
    return points_[index(a)][widest] < points_[index(b)][widest];
  });
  split_axis_[middle] = static_cast<std::uint8_t>(widest);
  build(begin, middle);
  build(middle + 1, end);
}

void PointTree::find(const Point& p, double radius, std::vector<std::int32_t>& found) const {
  found.clear();
  collect(0, order_.size(), p, radius, found);
  std::sort(found.begin(), found.end());
}

void PointTree::collect(std::size_t begin, std::size_t end, const Point& p, double radius,
                        std::vector<std::int32_t>& found) const {
  const auto examine = [&](std::size_t i) {
    const Vector d = points_[index(order_[i])] - p;
    if (dot(d, d) < radius * radius) found.push_back(order_[i]);
  };
  if (end - begin <= leaf_size) {
    for (std::size_t i = begin; i < end; ++i) examine(i);
    return;
  }
  const std::size_t middle = begin + (end - begin) / 2;
  const std::size_t axis = split_axis_[middle];
  const double offset = p[axis] - points_[index(order_[middle])][axis];
  examine(middle);
  if (offset <= radius) collect(begin, middle, p, radius, found);
  if (offset >= -radius) collect(middle + 1, end, p, radius, found);
}

}  // namespace crackle::geometry
