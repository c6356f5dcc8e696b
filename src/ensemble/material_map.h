// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"
#include "geometry/realization.h"
#include "input/model.h"

#include <cstdint>
#include <optional>

namespace crackle::ensemble {

/// Gives the tetrahedra of a sample's realization the materials or factors of the input's raster, at their
/// centroids; nothing without [material.map].
/// @throws std::runtime_error as io::Raster, and naming the tetrahedron whose value is no material or no
///   factor
void apply_material_map(const input::Model& model, const geometry::Body& body, std::uint64_t sample,
                        geometry::Realization& realization);

/// Reads the raster of the first sample. @throws std::runtime_error as apply_material_map
void check_material_map(const std::optional<input::MaterialMap>& map, const geometry::Body& body);

}  // namespace crackle::ensemble
