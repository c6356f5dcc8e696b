// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/experiment/calibration.h"
#include "synthetic_likelihood.h"

#include <Eigen/Dense>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace crackle::experiment {

/// Paths as few numbers: principal components of the samples' offsets.
struct PathComponents {
  PathFrame frame;
  std::vector<std::size_t> stations;  ///< of the frame, that experiments and samples reach
  Eigen::VectorXd mean;               ///< offset at each of them [m]
  Eigen::MatrixXd basis;              ///< stations x components, orthonormal columns
  double shape_p_value = 1;           ///< as in CalibrationChecks
};

/// Experiments and samples as components.
struct CalibrationData {
  std::vector<input::RandomInput> random = {};
  std::vector<std::vector<double>> draws = {};  ///< values of the inputs [SI]: draws x inputs
  EmulatedValues values = {};                   ///< of the samples, as computed
  Eigen::MatrixXd as_read = {};                 ///< likewise, as if read or measured
  ObservedComponents observed = {};
  std::optional<PathComponents> path = {};  ///< its components are the first ones
  std::vector<std::size_t> experiments = {};
  std::vector<std::uint64_t> left_out = {};  ///< numbers of samples that lack a component
  std::vector<std::string> notes = {};
};

/// Covariance of a smooth deviation with unit variance at places along a line; its correlation length is a
/// third of theirs.
Eigen::MatrixXd smooth_shape(const std::vector<double>& places);

/// The experiments as components.
/// @param values of the experiments: experiments x components; NaN: not observed
void set_observed(const Eigen::MatrixXd& values, ObservedComponents& observed);

/// @throws std::runtime_error when experiments and samples have nothing in common
CalibrationData calibration_data(std::span<const Experiment> experiments, const ObservedSamples& samples,
                                 const geometry::Body& body, const input::Parameters& parameters);

}  // namespace crackle::experiment
