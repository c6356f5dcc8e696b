// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"

namespace crackle::input {

/// The band of softening tetrahedra that a crack takes, in spacings: what makes a cracked strip with
/// softening run away at Griffith's load.
inline constexpr double spacings_per_band = 1.03;
/// Spacings up to this share of the process zone's length resolve it.
inline constexpr double resolving_share = 1.0 / 3;

/// E G / strength^2, the length of the zone in which a crack softens the material [m].
double process_zone_length(const Parameters& parameters);

/// The spacing from which on softening tetrahedra would snap back: they hold more energy at the strength, in
/// equibiaxial plane strain or in uniaxial stress, than softening takes [m].
double snap_back_spacing(const Parameters& parameters);

}  // namespace crackle::input
