// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"
#include "geometry/condition_region.h"

#include <span>

namespace crackle::geometry {

/// True if any region is smaller than a whole face.
bool has_borders(const Body& plain, std::span<const ConditionRegion> regions);

/// The body with the borders of loaded and constrained regions imprinted on its faces. Each border is an edge
/// between corners, like those of the body: it has its own points, which move only along it, and no boundary
/// triangle crosses it. Thus in every realization a region is a union of whole boundary triangles, or of
/// whole edges.
///
/// Faces are those of the body, undivided; lines are parallel to the own axes of the faces, or, in faces that
/// are level with none of the axes that limit a region, to the planes at its limits.
/// @param regions of the conditions of the input, in their order
/// @throws std::runtime_error when a region contains no part of its face
Complex imprint(const Body& plain, std::span<const ConditionRegion> regions);

}  // namespace crackle::geometry
