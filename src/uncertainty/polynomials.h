// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/study.h"

#include <span>
#include <vector>

namespace crackle::uncertainty {

/// The highest degree of polynomials that differ on a distribution's values: one less than there are.
int most_degree(const input::RandomInput& random);

/// The orthonormal polynomials of a random input's distribution up to a degree, at given values of that
/// input: Hermite polynomials of the corresponding standard normal variable for normal, lognormal and Weibull
/// distributions, Legendre polynomials for the uniform one, and those of Stieltjes' procedure for the others.
/// @param values of the input [SI]
/// @return (highest_degree + 1) x values.size(); 0 above most_degree
/// @throws std::runtime_error when the distribution is degenerate
std::vector<std::vector<double>> orthonormal_polynomials(const input::RandomInput& random,
                                                         std::span<const double> values, int highest_degree);

}  // namespace crackle::uncertainty
