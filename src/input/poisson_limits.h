// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/parameters.h"

#include <cmath>

namespace crackle::input {

/// Range of Poisson's ratio for which the relation of strength and toughness has been measured. Above it,
/// linear tetrahedra lock.
inline constexpr double least_measured_poisson_ratio = 0;
inline constexpr double greatest_measured_poisson_ratio = 0.45;

/// Decreases from `at_zero` with Poisson's ratio: towards 0.5 the pressure of linear tetrahedra oscillates
/// increasingly, and the most loaded ones break earlier.
inline double fitted_to_poisson_ratio(double at_zero, double exponent, double poisson_ratio) {
  return at_zero * (1 + poisson_ratio) * std::pow(1 - 2 * poisson_ratio, exponent);
}

/// A strength criterion has no toughness of its own: a slow crack through tetrahedra of spacing h releases
/// the energy c(nu) strength^2 h / E per crack area. This is c, fitted to the instability loads of cracked
/// strips and of bars in three-point bending (jobs/method.md).
inline double toughness_factor(Release release, double poisson_ratio) {
  return fitted_to_poisson_ratio(traits(release).toughness_factor, 0.46, poisson_ratio);
}

}  // namespace crackle::input
