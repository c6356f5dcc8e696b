// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/complex.h"
#include "plane/material_layout.h"
#include "plane/side_index.h"

#include <array>
#include <vector>

namespace crackle::geometry {

/// Divides a plate into materials. Its layers are parted by walls along x, and by caps normal to x between
/// them; both are inner faces. An inner wall is a rectangle through one layer. All caps at one x are one
/// face, with gaps.
/// @param complex the plate of the specimen
/// @param interfaces pairs of materials
/// @throws std::runtime_error as plane::material_layout
void divide(Complex& complex, const plane::Specimen& specimen, std::vector<std::array<int, 2>> interfaces);

/// True if materials change at a level of x, beside a line.
bool is_in_cap(const plane::MaterialLayout& layout, const plane::MaterialLayout::Line& line,
               std::size_t level, bool on_left);

plane::Side side_of(const plane::MaterialLayout& layout, const plane::MaterialLayout::Line& line);

/// The lengths of inner walls, their distances, and the thicknesses of layers.
/// @param layout of the specimen
SpacingRule region_spacing(const plane::Specimen& specimen, const plane::MaterialLayout& layout);

}  // namespace crackle::geometry
