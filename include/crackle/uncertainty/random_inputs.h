// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"

#include <cstdint>
#include <vector>

/// Random inputs: the values that samples have, and what their results owe to them.
namespace crackle::uncertainty {

/// The value below which a share `probability`, above 0 and below 1, of a distribution lies [SI]; by
/// OpenTURNS.
/// @throws std::runtime_error when the distribution has none
double quantile(const input::RandomInput& random, double probability);

/// Point `number` of a plan in the unit cube; each coordinate above 0 and below 1. It depends on the
/// arguments only, on `n_points` for a Latin hypercube alone.
/// @return n_dimensions values
/// @throws std::runtime_error when a Sobol' sequence has no so many dimensions, or a Latin hypercube no such
///   point
std::vector<double> plan_point(input::SamplingPlan plan, std::uint64_t seed, std::uint64_t n_points,
                               std::size_t n_dimensions, std::uint64_t number);

/// The values that the random inputs have in a sample [SI], rounded to six digits so that processors agree.
std::vector<double> drawn_values(const input::Parameters& parameters, std::uint64_t sample);

/// The input of a sample: the ensemble's own without random inputs.
/// @throws std::runtime_error with the values when they make no sound input
input::Parameters sample_parameters(const input::Parameters& parameters, std::uint64_t sample);

}  // namespace crackle::uncertainty
