// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <vector>

namespace crackle::geometry {

/// The symmetries of the body that also map the mesh regions onto regions of the same spacing, to 1e-12 of
/// the body's largest size.
std::vector<Symmetry> symmetries(const Body& body, const input::Mesh& mesh);

/// The body's symmetry with this code.
/// @throws std::invalid_argument when there is none
Symmetry symmetry_of(const Body& body, std::uint8_t code);

}  // namespace crackle::geometry
