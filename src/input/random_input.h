// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"

#include <array>
#include <string>
#include <vector>

namespace crackle::input {

enum class RandomDistribution {
  normal,
  lognormal,
  uniform,
  triangular,
  weibull,
  beta,
  truncated,
  discrete,   ///< some values
  empirical,  ///< like measured values, linear between them
};
/// As spelled in the input.
inline constexpr std::array distribution_names{"normal", "lognormal", "uniform",  "triangular", "weibull",
                                               "beta",   "truncated", "discrete", "empirical"};

/// A number of the input that changes with another one, such as the far end of a support that is moved.
struct MovedNumber {
  std::string key = {};
  double own = 0;         ///< value in the input itself [SI]
  std::string unit = {};  ///< as RandomInput::unit
};

/// A number of the input that varies between samples. Parameters of the distribution are in the SI unit of
/// that number; NaN: not given.
struct RandomInput {
  std::string key = {};                 ///< "material.youngs_modulus", "specimen.notch[0].depth"
  std::string unit = {};                ///< SI unit; empty for a dimensionless number
  double own = 0;                       ///< value in the input itself
  std::vector<MovedNumber> moved = {};  ///< change with it, by the same amount or factor
  bool by_factor = false;
  double exponent = 0;  ///< beta of a unit "Pa^beta s"; 0 otherwise
  RandomDistribution distribution = RandomDistribution::normal;
  double mean = not_a_number;
  double standard_deviation = not_a_number;
  double lower = not_a_number;
  double upper = not_a_number;
  double mode = not_a_number;
  double shape = not_a_number;
  double scale = not_a_number;
  std::vector<double> values = {};   ///< of a discrete or an empirical distribution
  std::vector<double> weights = {};  ///< of the discrete values; empty: equal
};

}  // namespace crackle::input
