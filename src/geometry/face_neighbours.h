// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/point.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::geometry {

/// For each tetrahedron and corner the tetrahedron across the opposite face; -1 if there is none.
std::vector<std::array<std::int32_t, 4>> face_neighbours(std::span<const Tetrahedron> tetrahedra);

}  // namespace crackle::geometry
