// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/geometry/point.h"
#include "crackle/geometry/realization.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::geometry {

/// The part of a box covered by a region.
Box box_of(const input::MeshRegion& region, const Box& bounds);

/// The first region that contains each point; -1 if there is none.
std::vector<std::int32_t> region_numbers(std::span<const Point> points, const Body& body,
                                         const input::Mesh& mesh);

/// Mesh contents of one region.
struct RegionContent {
  std::int64_t nodes = 0;
  std::int64_t tetrahedra = 0;  ///< by their centroids
};

/// Contents of each region and, last, of the rest of the body.
std::vector<RegionContent> region_contents(const Realization& realization, const Body& body,
                                           const input::Mesh& mesh);

}  // namespace crackle::geometry
