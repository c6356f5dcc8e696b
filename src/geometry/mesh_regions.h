// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"
#include "geometry/mother_points.h"
#include "geometry/point.h"
#include "geometry/realization.h"
#include "input/model.h"

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

/// 1 for tetrahedra in the interior of the finely meshed zone, where cracks start: at their centroids the
/// spacing is at most twice the notch spacing, and the surface at least two spacings away. 0 for others.
std::vector<std::int32_t> refined_interior(const Realization& realization, const Body& body,
                                           const input::Mesh& mesh);

/// Displacement of each node from its mother point over the largest possible, perturbation x spacing [-]; NaN
/// along an axis in which the point cannot move.
std::vector<Point> relative_displacements(const Body& body, const MotherPoints& base,
                                          const Realization& realization, const input::Mesh& mesh);

}  // namespace crackle::geometry
