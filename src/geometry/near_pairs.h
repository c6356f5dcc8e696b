// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/point.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::geometry {

/// Pairs of points, each once: point begin + i with `other[first[i]]` to `other[first[i + 1] - 1]`.
struct NearPairs {
  std::vector<std::size_t> first;
  std::vector<std::int32_t> other;
};

/// The pairs of points whose distance is below the mean of their radii, without those of two points from
/// number `n_movable` on; of them those listed by the points from `begin` to `end` - 1, which together with
/// those listed by the others are all. In time proportional to the number of points, by cell lists (Hockney
/// and Eastwood 1988, chapter 8) with one grid for each factor of two between the radii. Which point lists a
/// pair, and the order of the pairs, depend only on points and radii.
/// @param radius one for each point, positive [m]
NearPairs near_pairs(std::span<const Point> points, std::span<const double> radius, std::size_t n_movable,
                     std::size_t begin, std::size_t end);

}  // namespace crackle::geometry
