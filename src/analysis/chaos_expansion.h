// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/study.h"

#include <Eigen/Dense>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::analysis {

// Not a library's: OpenTURNS' expansions leave out single values instead of draws in cross-validation, divide
// by the variance of the model instead of the total one, take hundreds of times as long (sensitivities need
// 400 fits for each result), and have bits that depend on the installed BLAS.

/// The products of orthonormal polynomials of several random inputs, up to a total degree, at given draws.
class ChaosBasis {
public:
  /// Uses as many degrees as a least-squares fit to the number of draws supports.
  /// @param values of the inputs: draws x inputs
  /// @throws std::runtime_error as uncertainty::orthonormal_polynomials
  ChaosBasis(const std::vector<input::RandomInput>& random, const std::vector<std::vector<double>>& values);

  int highest_degree() const { return static_cast<int>(n_terms_.size()) - 1; }
  /// Number of products up to a degree: the first columns of table().
  Eigen::Index n_terms(int degree) const { return n_terms_[static_cast<std::size_t>(degree)]; }
  const Eigen::MatrixXd& table() const { return table_; }  ///< draws x products
  /// Degree in each input of each product.
  const std::vector<std::vector<int>>& degrees() const { return degrees_; }

private:
  std::vector<std::vector<int>> degrees_;
  std::vector<Eigen::Index> n_terms_;  ///< by highest total degree
  Eigen::MatrixXd table_;
};

/// Values of one result: value i belongs to draw draw[i] of the basis.
struct DrawnValues {
  std::vector<std::size_t> draw;  ///< ascending
  Eigen::VectorXd value;

  /// Number of distinct draws.
  std::size_t n_draws() const;
};

/// Shares of the total variance, by input; 0 <= first <= total <= 1.
struct SobolIndices {
  std::vector<double> first;
  std::vector<double> total;
};

/// The degree whose expansion best predicts values in cross-validation.
struct ChosenDegree {
  int degree = 0;
  double predicted = 0;  ///< share of the variance
};
ChosenDegree choose_degree(const ChaosBasis& basis, const DrawnValues& values);

/// The expansion of a degree by least squares, at the values' draws.
Eigen::VectorXd fitted_values(const ChaosBasis& basis, const DrawnValues& values, int degree);

/// Sobol' indices from the expansion of a degree by weighted least squares.
/// @param weight integer multiplicity of each value
/// @param corrects remove the bias of squared coefficients due to scatter
/// @return NaN if the weights leave too few draws
SobolIndices sobol_indices(const ChaosBasis& basis, const DrawnValues& values, int degree,
                           const Eigen::VectorXd& weight, bool corrects);

}  // namespace crackle::analysis
