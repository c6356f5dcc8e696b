// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "emulator.h"
#include "importance_sampling.h"

#include <Eigen/Dense>
#include <string>
#include <vector>

namespace crackle::experiment {

/// Neighbouring components that describe one quantity.
struct QuantityBlock {
  std::string name = {}, unit = {};
  Eigen::Index first = 0, count = 0;  ///< components
  /// Covariance of a smooth deviation: of the model from the experiments, or of a specimen from others.
  Eigen::MatrixXd shape = {};
};

/// Experiments as components.
struct ObservedComponents {
  Eigen::VectorXd mean;  ///< of the experiments that have the component
  /// Covariances of means over those of single experiments: the number of experiments that have both
  /// components over the product of the numbers that have each.
  Eigen::MatrixXd share;
  Eigen::MatrixXd error;  ///< covariance of reading or measuring, of a single experiment
  std::vector<QuantityBlock> blocks;
  /// Orthonormal contrasts of the experiments that have all components, one a row.
  Eigen::MatrixXd contrasts;

  ObservedComponents only(const std::vector<Eigen::Index>& columns,
                          const std::vector<QuantityBlock>& blocks) const;
};

/// Terms of the covariance that can be left out or added.
struct CovarianceTerms {
  bool has_discrepancy = false;       ///< of the model, for each quantity
  bool has_specimen_scatter = false;  ///< beyond mesh scatter and reading, for each quantity
  bool has_emulator_error = true;     ///< else mean and scatter count as known, for tests
};

/// Synthetic likelihood (Wood 2010, Nature 466, 1102): the mean of the experiments has a t distribution about
/// the emulator (Sellentin and Heavens 2016, MNRAS 456, L132), whose covariance is the mesh scatter and the
/// error of reading over the number of experiments, and the error of the emulator. The discrepancy (Kennedy
/// and O'Hagan 2001, J. R. Stat. Soc. B 63, 425) and the scatter between specimens have half-Cauchy scales a
/// priori, relative to the scatter of a sample as read (Gelman 2006, Bayesian Anal. 1, 515).
///
/// Variables: the standard normal ones of the inputs, then those of the scales of the discrepancy and of the
/// specimens' scatter, by quantity, as far as they take part.
class SyntheticLikelihood {
public:
  SyntheticLikelihood(const Emulator& emulator, const ObservedComponents& observed,
                      const CovarianceTerms& terms);

  Eigen::Index n_variables() const;
  Likelihood operator()(const Eigen::VectorXd& variables) const;

  struct Expected {
    Eigen::VectorXd mean;
    Eigen::MatrixXd covariance;
  };
  /// Distribution of the mean of the experiments.
  Expected expected(const Eigen::VectorXd& variables) const;
  double degrees_of_freedom() const { return degrees_; }

  /// Scale of the discrepancy or the specimens' scatter in a quantity, as the root mean square over the
  /// places of that quantity. @param number among the variables after the inputs
  double scale(Eigen::Index number, double variable) const;

private:
  Eigen::MatrixXd shapes(const Eigen::VectorXd& variables, Eigen::Index first) const;

  const Emulator& emulator_;
  const ObservedComponents& observed_;
  CovarianceTerms terms_;
  Eigen::MatrixXd scatter_, shared_scatter_;  ///< for a t distribution of degrees_
  double degrees_;
  Eigen::VectorXd least_variance_;
  std::vector<double> prior_scale_;  ///< of each block
};

}  // namespace crackle::experiment
