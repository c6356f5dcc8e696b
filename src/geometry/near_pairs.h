// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/point.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::geometry {

/// Pairs of points, each once: point i with `other[first[i]]` to `other[first[i + 1] - 1]`.
struct NearPairs {
  std::vector<std::size_t> first;
  std::vector<std::int32_t> other;
};

/// The pairs of points whose distance is below the mean of their radii, without those of two points from
/// number `n_movable` on. In time proportional to the number of points, by cell lists (Hockney and Eastwood
/// 1988, chapter 8) with one grid for each factor of two between the radii. The order of the pairs depends
/// only on the arguments.
/// @param radius one for each point, positive [m]
NearPairs near_pairs(std::span<const Point> points, std::span<const double> radius, std::size_t n_movable);

}  // namespace crackle::geometry
