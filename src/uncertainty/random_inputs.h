// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/parameters.h"

#include <cstdint>
#include <vector>

/// Random inputs: sampling of their values.
namespace crackle::uncertainty {

/// The quantile of a distribution for a probability between 0 and 1, exclusive [SI].
/// @throws std::runtime_error when the distribution has none
double quantile(const input::RandomInput& random, double probability);

/// Point `number` of a plan in the unit cube; each coordinate is above 0 and below 1. Depends on the
/// arguments only, and on `n_points` only for a Latin hypercube.
/// @return n_dimensions values
/// @throws std::runtime_error when a Sobol' sequence does not have that many dimensions, or a Latin hypercube
///   has no such point
std::vector<double> plan_point(input::SamplingPlan plan, std::uint64_t seed, std::uint64_t n_points,
                               std::size_t n_dimensions, std::uint64_t number);

/// The values of the random inputs in a sample [SI], rounded to six digits so that processors agree.
std::vector<double> drawn_values(const input::Study& study, std::uint64_t sample);

/// The input of a sample; the ensemble's own without random inputs.
/// @throws std::runtime_error with the values when they make an invalid input
input::Parameters sample_parameters(const input::Parameters& parameters, std::uint64_t sample);

}  // namespace crackle::uncertainty
