// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/vector.h"
#include "crackle/input/profile.h"

#include <array>
#include <cstddef>

namespace crackle::mechanics {

/// Integrals of a factor times each linear shape function over a segment (two corners) or a triangle (three).
/// Exact, as both are cut where the factor has a kink.
/// @param measure its length [m] or area [m^2]
template <std::size_t n_corners>
std::array<double, n_corners> factor_shares(const input::Profile& factor,
                                            const std::array<Vector, n_corners>& corners, double measure);

}  // namespace crackle::mechanics
