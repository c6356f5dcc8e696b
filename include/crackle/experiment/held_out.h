// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/experiment/experiments_file.h"
#include "crackle/experiment/observation.h"

#include <cstddef>
#include <functional>
#include <vector>

/// Samples in the place of experiments, which shows what a match finds when the model is right.
namespace crackle::experiment {

struct HeldOut {
  std::vector<Experiment> experiments;
  ObservedSamples others;
};

/// A sample as an experiment read without error: the main arm of its leading crack, and its loads.
Experiment as_experiment(const ObservedSample& sample);

/// Takes `n` samples at random, the same ones in each call.
/// @throws std::runtime_error unless n is at least 1 and leaves two samples or more
HeldOut hold_out(ObservedSamples samples, std::size_t n);

/// The p-value of each sample, as an experiment, against all others.
/// @param on_progress called with the number of samples done
std::vector<double> p_values_of_samples(const ObservedSamples& samples, const geometry::Body& body,
                                        const std::function<void(std::size_t)>& on_progress);

/// How often these p-values are at most 0.05, 0.1, 0.25, 0.5, and 0.75, which uniform ones are in as many
/// cases.
std::string p_values_text(std::vector<double> p_values);

/// A JSON list with the number and the p-value of each sample.
std::string p_values_json(const ObservedSamples& samples, const std::vector<double>& p_values);

}  // namespace crackle::experiment
