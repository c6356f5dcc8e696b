// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>

namespace crackle::geometry {

using PlanePoint = std::array<double, 2>;

/// True if the interiors of two convex polygons intersect, where the first one is the convex hull of four
/// points. Exact, by orientation tests without tolerances.
/// @param polygon corners in order
bool overlap(const std::array<PlanePoint, 4>& points, std::span<const PlanePoint> polygon);

}  // namespace crackle::geometry
