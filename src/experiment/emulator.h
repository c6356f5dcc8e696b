// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/chaos_expansion.h"
#include "crackle/input/parameters.h"

#include <Eigen/Dense>
#include <cstddef>
#include <memory>
#include <vector>

/// The results of an ensemble as functions of its random inputs.
namespace crackle::experiment {

/// Standard deviations of a normal distribution that tables of inputs reach to.
inline constexpr double most_deviations = 7.5;

/// Random inputs as functions of independent standard normal variables, and the polynomials of each. Looked
/// up in a table, since a quantile of a beta distribution takes some 10 us; linear interpolation is off by
/// 1e-5 of a standard deviation.
class InputTable {
public:
  /// @throws std::runtime_error when a distribution is degenerate
  InputTable(const std::vector<input::RandomInput>& random, int highest_degree);

  std::size_t n_inputs() const { return value_.size(); }
  double value(std::size_t input, double variable) const;  ///< [SI]
  double polynomial(std::size_t input, int degree, double variable) const;
  double mean(std::size_t input) const;
  double standard_deviation(std::size_t input) const;

private:
  double moment(std::size_t input, double about, int order) const;

  std::vector<std::vector<double>> value_;                    ///< inputs x nodes
  std::vector<std::vector<std::vector<double>>> polynomial_;  ///< inputs x degrees x nodes
};

/// The terms of chaos expansions, at the draws of an ensemble and everywhere else.
struct EmulatorBasis {
  EmulatorBasis(const std::vector<input::RandomInput>& random, const std::vector<std::vector<double>>& draws);

  Eigen::VectorXd terms(const Eigen::VectorXd& variables, Eigen::Index n_terms) const;

  analysis::ChaosBasis basis;
  InputTable table;
};

/// Values of several components in the samples. Row i belongs to draw `draw[i]` of a basis.
struct EmulatedValues {
  std::vector<std::size_t> draw;  ///< ascending
  Eigen::MatrixXd value;          ///< samples x components

  std::size_t n_draws() const;
  EmulatedValues without(std::size_t draw) const;
};

/// The mean of each component by a polynomial chaos expansion (least squares, degree by cross-validation),
/// and the scatter of all components about it.
class Emulator {
public:
  struct Prediction {
    Eigen::VectorXd mean;
    Eigen::VectorXd leverage;  ///< of the regression of each component
  };

  /// Chooses the degree of each component.
  Emulator(std::shared_ptr<const EmulatorBasis> basis, const EmulatedValues& values);

  /// With the degrees of this one; @param columns of the values that are used
  Emulator refitted(const EmulatedValues& values, const std::vector<Eigen::Index>& columns) const;

  Prediction predict(const Eigen::VectorXd& variables) const;

  const EmulatorBasis& basis() const { return *basis_; }
  Eigen::Index n_components() const { return coefficient_.cols(); }
  /// Covariance of the samples about the mean.
  const Eigen::MatrixXd& scatter() const { return scatter_; }
  /// The factor of the leverage in the covariance of the mean: the scatter, or with several samples of a
  /// draw, which share the error of the expansion, the covariance of the sums over draws per sample.
  const Eigen::MatrixXd& shared_scatter() const { return shared_scatter_; }
  /// Variance of each component over all samples.
  const Eigen::VectorXd& variance() const { return variance_; }
  double degrees_of_freedom() const { return degrees_of_freedom_; }
  double mean_leverage() const { return mean_leverage_; }
  const std::vector<int>& degree() const { return degree_; }
  /// Share of each component's variance that is predicted in cross-validation.
  const std::vector<double>& predicted() const { return predicted_; }
  Eigen::MatrixXd residuals(const EmulatedValues& values) const;
  Eigen::Index n_terms(Eigen::Index component) const;

private:
  Emulator(std::shared_ptr<const EmulatorBasis> basis, const EmulatedValues& values, std::vector<int> degree,
           std::vector<double> predicted);

  std::shared_ptr<const EmulatorBasis> basis_;
  std::vector<int> degree_;
  std::vector<double> predicted_;
  Eigen::MatrixXd triangle_;     ///< R of the terms at the samples, Q R
  Eigen::MatrixXd coefficient_;  ///< of the columns of Q; zero above each component's degree
  Eigen::MatrixXd scatter_, shared_scatter_;
  Eigen::VectorXd variance_;
  double degrees_of_freedom_ = 0, mean_leverage_ = 0;
};

}  // namespace crackle::experiment
