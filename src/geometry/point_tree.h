// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/point.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::geometry {

/// A balanced k-d tree over fixed points, for queries by radius.
class PointTree {
public:
  /// Keeps a view of `points`.
  explicit PointTree(std::span<const Point> points);

  /// Sets `found` to the numbers of the points closer than `radius` to p, ascending.
  void find(const Point& p, double radius, std::vector<std::int32_t>& found) const;

private:
  void build(std::size_t begin, std::size_t end);
  void collect(std::size_t begin, std::size_t end, const Point& p, double radius,
               std::vector<std::int32_t>& found) const;

  std::span<const Point> points_;
  std::vector<std::int32_t>
      order_;  ///< the root of a range is its middle element, its children the two halves
  std::vector<std::uint8_t> split_axis_;  ///< at each root
};

}  // namespace crackle::geometry
