// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace crackle::input {

/// Range of Poisson's ratio for which the relation of strength and toughness has been measured. Above it,
/// linear tetrahedra lock.
inline constexpr double least_measured_poisson_ratio = 0;
inline constexpr double greatest_measured_poisson_ratio = 0.45;

}  // namespace crackle::input
