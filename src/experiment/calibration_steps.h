// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibration_data.h"
#include "importance_sampling.h"
#include "synthetic_likelihood.h"

#include <cstdint>
#include <vector>

namespace crackle::experiment {

/// Effort for the posterior, and for those of parts of the observations and of left-out draws.
inline constexpr SamplingEffort full_effort{2000, 4000, 20};
inline constexpr SamplingEffort small_effort{500, 500, 8};

inline PosteriorPoints posterior_of(const SyntheticLikelihood& likelihood, const SamplingEffort& effort,
                                    const RandomStream& stream) {
  return sample_posterior(
      likelihood.n_variables(), [&](const Eigen::VectorXd& x) { return likelihood(x); }, effort, stream);
}

/// Values of an input at the points of a posterior [SI].
std::vector<double> input_values(const InputTable& table, std::size_t input, const PosteriorPoints& points);

/// @param weights sum 1
Spread spread_of(const std::vector<double>& values, const Eigen::VectorXd& weights);

/// Points with equal weights: indices, each as often as it is drawn, ascending (systematic resampling).
std::vector<std::size_t> resampled(const Eigen::VectorXd& weights, std::size_t n, RandomStream stream);

/// An emulator of all components.
Emulator emulator_of(const CalibrationData& data);

/// @throws std::runtime_error with too few draws for an emulator
Calibration calibrate(const CalibrationData& data, const CalibrationOptions& options, std::uint64_t seed);

/// Predictions of all components, in `calibration`.
void add_predictions(const CalibrationData& data, const SyntheticLikelihood& likelihood,
                     const PosteriorPoints& points, const RandomStream& stream, Calibration& calibration);

/// All but what the posterior itself tells.
CalibrationChecks calibration_checks(const CalibrationData& data, const Emulator& emulator,
                                     const RandomStream& stream);

/// Sentences on failed checks.
std::vector<std::string> check_warnings(const Calibration& calibration);

}  // namespace crackle::experiment
