// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/model.h"

namespace crackle::input {

/// Width of the band of softening tetrahedra in a crack, in spacings: calibrated so that a cracked strip with
/// softening becomes unstable at Griffith's load.
inline constexpr double spacings_per_band = 1.03;
/// Spacings up to this share of the process zone length resolve the process zone.
inline constexpr double resolving_share = 1.0 / 3;

/// E G / strength^2, the length of the process zone [m]; the least of several materials.
double process_zone_length(const Model& model);

/// The spacing above which softening tetrahedra would snap back: the energy stored at the strength, in
/// equibiaxial plane strain or in uniaxial stress, exceeds that dissipated by softening [m].
double snap_back_spacing(const Model& model);

}  // namespace crackle::input
