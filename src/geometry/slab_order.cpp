// SPDX-License-Identifier: GPL-3.0-or-later
#include "slab_order.h"

#include "crackle/common/index.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <span>

namespace crackle::geometry {

namespace {

/// Sorts by the first axis, cuts into layers of one mean spacing, and sorts each layer by the remaining axes.
void sort_in_layers(const MotherPoints& points, std::span<const std::size_t> axes,
                    std::span<std::int32_t> order) {
  const auto coordinate = [&](std::int32_t i) { return points.position[index(i)][axes[0]]; };
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return coordinate(a) != coordinate(b) ? coordinate(a) < coordinate(b) : a < b;
  });
  if (axes.size() == 1) return;
  for (std::size_t begin = 0; begin < order.size();) {
    double sum = 0;
    std::size_t end = begin;
    for (; end < order.size(); ++end) {
      if (end > begin &&
          (coordinate(order[end]) - coordinate(order[begin])) * static_cast<double>(end - begin) > sum)
        break;
      sum += points.spacing[index(order[end])];
    }
    sort_in_layers(points, axes.subspan(1), order.subspan(begin, end - begin));
    begin = end;
  }
}

}  // namespace

MotherPoints in_slab_order(const MotherPoints& points, const Point& size) {
  std::array<std::size_t, 3> axes{0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](std::size_t a, std::size_t b) { return size[a] > size[b]; });
  std::vector<std::int32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  sort_in_layers(points, axes, order);

  MotherPoints sorted;
  sorted.position.reserve(points.size());
  sorted.spacing.reserve(points.size());
  sorted.movable.reserve(points.size());
  for (const std::int32_t i : order) {
    sorted.position.push_back(points.position[index(i)]);
    sorted.spacing.push_back(points.spacing[index(i)]);
    sorted.movable.push_back(points.movable[index(i)]);
  }
  return sorted;
}

}  // namespace crackle::geometry
