// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"

#include <span>
#include <vector>

namespace crackle::uncertainty {

/// The polynomials up to a degree that are orthonormal under a random input's distribution, at given values
/// of that input: Hermite's of the standard normal variable that has the same probability for normal,
/// lognormal and Weibull distributions, Legendre's for the uniform one, and for the others those that
/// OpenTURNS makes.
/// @param values of the input [SI]
/// @return (highest_degree + 1) x values.size()
/// @throws std::runtime_error when OpenTURNS cannot make them
std::vector<std::vector<double>> orthonormal_polynomials(const input::RandomInput& random,
                                                         std::span<const double> values, int highest_degree);

}  // namespace crackle::uncertainty
