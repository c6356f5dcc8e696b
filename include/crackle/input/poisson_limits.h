// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace crackle::input {

/// Poisson's ratios for which the strength that belongs to a toughness has been measured. Above the greatest,
/// linear tetrahedra lock.
inline constexpr double least_measured_poisson_ratio = 0;
inline constexpr double greatest_measured_poisson_ratio = 0.45;

}  // namespace crackle::input
