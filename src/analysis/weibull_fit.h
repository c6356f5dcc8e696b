// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/censored_values.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

/// Weibull's distribution F(x) = 1 - exp(-(x / scale)^modulus) of loads, by maximum likelihood, where some
/// samples did not break.
namespace crackle::analysis {

struct FittedParameter {
  double value, lower, upper;
};

struct WeibullFit {
  FittedParameter modulus;  ///< without bias where all values are known
  FittedParameter scale;    ///< in the unit of the values
  int n_broken = 0, n_unbroken = 0;
};

/// Where all values are known, the modulus found over the true one has a distribution that depends on their
/// number only, and so has the scale's pivot (Thoman, Bain and Antle 1969, Technometrics 11, 445): intervals
/// and the factor that removes the bias come from simulation, the same in each call. With bounds the
/// intervals are those of the likelihood ratio.
/// @param values independent, [unit] or lower bounds of unbroken samples
/// @return nothing for fewer than five known values, or where one is not above 0 or all are equal
std::optional<WeibullFit> weibull_fit(const CensoredValues& values, double confidence);

/// The fit of a load.
struct LoadFit {
  ResultInfo load;
  WeibullFit fit;
};

/// Fits the load at the first break and the peak load, over the completed samples.
/// @param samples independent
std::vector<LoadFit> weibull_fits(std::span<const SampleSummary> samples, double confidence);

}  // namespace crackle::analysis
