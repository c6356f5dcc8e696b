// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/realization.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::geometry {

/// Realization::interface, from the other members.
/// @param pairs of materials
std::vector<std::uint8_t> interface_numbers(const Realization& realization,
                                            std::span<const std::array<int, 2>> pairs);

}  // namespace crackle::geometry
