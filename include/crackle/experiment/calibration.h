// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"
#include "crackle/experiment/observation.h"
#include "crackle/geometry/body.h"
#include "crackle/input/parameters.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// The random inputs of an ensemble, given experiments.
namespace crackle::experiment {

/// Level of the intervals of a calibration.
inline constexpr double calibration_level = 0.9;

struct CalibrationOptions {
  bool has_discrepancy = false;       ///< of the model from the experiments, unknown in size, by quantity
  bool has_specimen_scatter = false;  ///< between specimens, beyond that of meshes and of reading, likewise
};

/// A distribution in short.
struct Spread {
  double mean = not_a_number;
  double standard_deviation = not_a_number;
  double lower = not_a_number, upper = not_a_number;  ///< with equal tails, of calibration_level
};

struct CalibratedInput {
  input::RandomInput random;  ///< key, unit and prior
  Spread prior, posterior;

  /// Ratio of the standard deviations, posterior over prior.
  double ratio() const { return posterior.standard_deviation / prior.standard_deviation; }
};

/// The inputs by some of the observations.
struct Information {
  double bits = not_a_number;  ///< Kullback-Leibler divergence of the posterior from the prior
  std::vector<Spread> inputs = {};
};

/// A quantity's contribution to the posterior.
struct Contribution {
  std::string quantity = {};
  Information alone = {};
  std::optional<Information> without = {};  ///< from all others, if there are any
};

/// The size of a discrepancy or of the scatter between specimens: standard deviation.
struct CalibratedScale {
  std::string quantity, unit;
  bool is_discrepancy = true;
  Spread posterior;
};

/// The mean of as many new experiments after calibration.
struct Prediction {
  std::string name = {}, unit = {};
  Spread predicted = {};
  double observed = not_a_number;
  double place = not_a_number;  ///< share of the predictions below the observation
};

/// Predicted offsets at the stations of a path.
struct PredictedPath {
  PathFrame frame;
  std::vector<std::size_t> stations;  ///< of the frame, that are predicted
  std::vector<Prediction> at = {};    ///< each of them
};

/// How often intervals from the results of one draw, by an emulator without it, covered its inputs.
struct Coverage {
  std::string key = {};
  double level = 0;
  int n_draws = 0, n_covered = 0;
  double lower = 0, upper = 1;  ///< 95 % interval of the share
};

/// How well a component is emulated.
struct EmulatedComponent {
  std::string quantity = {};
  int degree = 0;
  double predicted = not_a_number;  ///< share of the variance, in cross-validation
  /// With several samples of a draw: the share of the variance that is scatter of the meshes, and the p-value
  /// (F-test) that the residuals of draws are no larger than the meshes explain.
  double mesh = not_a_number, lack_of_fit_p_value = not_a_number;
};

struct CalibrationChecks {
  std::vector<Coverage> coverage = {};
  double effective_size = not_a_number;  ///< of the posterior points
  /// Least distance of the observations from what the model gives, over all inputs: root of the Mahalanobis
  /// distance squared, in scatter and errors, and of the inputs from the middle of the prior squared.
  double distance = not_a_number;
  std::size_t n_components = 0;
  double distance_p_value = not_a_number;  ///< rank among the same distances of left-out draws
  double least_p_value = not_a_number;
  /// Rank of the part of paths that the components do not hold, if there are paths.
  double shape_p_value = not_a_number;
  std::vector<EmulatedComponent> components = {};
};

struct Calibration {
  std::vector<std::string> experiments = {};  ///< names of those that are used
  CalibrationOptions options = {};
  std::vector<CalibratedInput> inputs = {};
  std::vector<std::vector<double>> correlation = {};  ///< of the posterior: inputs x inputs
  double bits = not_a_number;                         ///< of all observations, as in Information
  std::vector<CalibratedScale> scales = {};
  std::vector<Contribution> contributions = {};
  std::vector<Prediction> predictions = {};
  std::optional<PredictedPath> path = {};
  CalibrationChecks checks = {};
  /// Thinned: each stands for its weight, which is a whole number.
  std::vector<std::vector<double>> draws = {};  ///< x inputs [SI]
  std::vector<int> weights = {};
  std::vector<std::string> warnings = {}, notes = {};
  std::size_t n_planned = 0, n_used = 0, n_draws = 0;
  std::vector<std::uint64_t> failed = {}, undecided = {}, missing = {}, left_out = {};
};

/// The posterior of the random inputs by a synthetic likelihood with an emulator of the samples' results. The
/// same in each call.
/// @param parameters of the ensemble
/// @throws std::runtime_error without random inputs, with too few draws for an emulator, and when experiments
///   and samples have nothing in common
Calibration calibrate(std::span<const Experiment> experiments, const ObservedSamples& samples,
                      const geometry::Body& body, const input::Parameters& parameters,
                      const CalibrationOptions& options);

/// The calibration as readable tables and sentences.
std::string to_text(const Calibration& calibration);

/// The same as a JSON document in SI units; NaN is null.
std::string to_json(const Calibration& calibration);

/// The posterior as [[random]] tables of an input: distributions of the prior's kind, or beta distributions
/// between the same bounds, with the posterior's means and standard deviations.
std::string posterior_tables(const Calibration& calibration);

}  // namespace crackle::experiment
