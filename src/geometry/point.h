// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "common/vector.h"

#include <array>
#include <cstdint>
#include <span>

namespace crackle::geometry {

using Point = Vector;  ///< [m]
using Tetrahedron = std::array<std::int32_t, 4>;
using Triangle = std::array<std::int32_t, 3>;

/// Mean of the corners of an edge, a triangle or a tetrahedron.
inline Point centroid(std::span<const Point> nodes, std::span<const std::int32_t> corners) {
  Point mean{};
  for (const std::int32_t node : corners)
    mean = mean + nodes[index(node)] / static_cast<double>(corners.size());
  return mean;
}

}  // namespace crackle::geometry
