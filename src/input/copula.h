// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/study.h"

#include <vector>

namespace crackle::input {

/// The correlations of the standard normal variables of a Gaussian copula with the rank correlations of the
/// random inputs (2 sin(pi rank / 6); Iman and Conover 1982, Commun. Stat. B 11, 311): a row for each.
std::vector<std::vector<double>> copula(const Study& study);

/// The lower triangle L with L L^T = copula: independent standard normal variables become correlated ones.
/// @return empty if the matrix is not positive definite
std::vector<std::vector<double>> copula_factor(const Study& study);

}  // namespace crackle::input
