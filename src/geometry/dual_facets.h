// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"
#include "geometry/realization.h"

#include <array>
#include <cstdint>
#include <vector>

namespace crackle::geometry {

/// The node pairs of a tetrahedron's six dual facets, in their order.
inline constexpr std::array<std::array<std::size_t, 2>, 6> dual_facet_nodes{
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// All dual facets as quadrilaterals: edge midpoint, face centroid, tetrahedron centroid, face centroid.
struct DualSurface {
  std::vector<Point> points;  ///< [m]
  std::vector<std::array<std::int32_t, 4>> quadrilaterals;
  std::vector<std::int32_t> tetrahedron;  ///< of each quadrilateral
};

DualSurface dual_surface(const Realization& realization);

}  // namespace crackle::geometry
