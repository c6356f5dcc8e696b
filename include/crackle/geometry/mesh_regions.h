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

/// The part of a box that a region covers.
Box box_of(const input::MeshRegion& region, const Box& bounds);

/// The first region that holds each point, -1 where none does.
std::vector<std::int32_t> region_numbers(std::span<const Point> points, const Body& body,
                                         const input::Mesh& mesh);

/// What of a mesh is in one region.
struct RegionContent {
  std::int64_t nodes = 0;
  std::int64_t tetrahedra = 0;  ///< by their centroids
};

/// Content of each region and, last, of what none of them holds.
std::vector<RegionContent> region_contents(const Realization& realization, const Body& body,
                                           const input::Mesh& mesh);

}  // namespace crackle::geometry
