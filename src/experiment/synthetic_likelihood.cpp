// SPDX-License-Identifier: GPL-3.0-or-later
#include "synthetic_likelihood.h"

#include "crackle/common/index.h"
#include "crackle/common/real.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace crackle::experiment {

namespace {

/// Standard deviation that results without scatter have, as a share of that over all samples.
constexpr double least_deviation = 1e-4;
/// Degrees of freedom that are as good as infinitely many.
constexpr double most_degrees = 1e8;

/// A half-Cauchy number of scale 1 from a standard normal one.
double half_cauchy(double variable) {
  const double upper = std::erfc(variable / std::numbers::sqrt2) / 2;
  return 1 / std::tan(std::numbers::pi / 2 * std::max(upper, 1e-15));
}

double log_t_density(double square, double log_determinant, double n, double degrees) {
  return std::lgamma((degrees + n) / 2) - std::lgamma(degrees / 2) -
         n / 2 * std::log(degrees * std::numbers::pi) - log_determinant / 2 -
         (degrees + n) / 2 * std::log1p(square / degrees);
}

double log_determinant_of(const Eigen::LLT<Eigen::MatrixXd>& factors) {
  return 2 * factors.matrixLLT().diagonal().array().log().sum();
}

}  // namespace

ObservedComponents ObservedComponents::only(const std::vector<Eigen::Index>& columns,
                                            const std::vector<QuantityBlock>& of_columns) const {
  return {mean(columns), share(columns, columns), error(columns, columns), of_columns,
          contrasts(Eigen::all, columns)};
}

SyntheticLikelihood::SyntheticLikelihood(const Emulator& emulator, const ObservedComponents& observed,
                                         const CovarianceTerms& terms)
    : emulator_(emulator),
      observed_(observed),
      terms_(terms),
      scatter_(emulator.scatter()),
      shared_scatter_(emulator.shared_scatter()),
      degrees_(most_degrees),
      least_variance_(std::pow(least_deviation, 2) * emulator.variance()) {
  const Eigen::MatrixXd single = scatter_ + observed.error;
  for (const QuantityBlock& block : observed.blocks) {
    const double variance = single.diagonal().segment(block.first, block.count).sum() +
                            least_variance_.segment(block.first, block.count).sum();
    prior_scale_.push_back(std::sqrt(variance / block.shape.trace()));
  }
  if (!terms.has_emulator_error) {
    shared_scatter_.setZero();
    return;
  }
  // The covariance is estimated; where much of it is known, the distribution is nearer to a normal one.
  const auto n = static_cast<double>(emulator.n_components());
  const double degrees = emulator.degrees_of_freedom() - n + 1;
  const double widening = emulator.degrees_of_freedom() / degrees;
  scatter_ *= widening;
  shared_scatter_ *= widening;
  const Eigen::MatrixXd estimated =
      observed.share.cwiseProduct(scatter_) + emulator.mean_leverage() * shared_scatter_;
  Eigen::MatrixXd all = estimated + observed.share.cwiseProduct(observed.error);
  all.diagonal() += least_variance_;
  const double share = all.llt().solve(estimated).trace() / n;
  degrees_ = std::min(most_degrees, degrees / std::max(share * share, degrees / most_degrees));
}

Eigen::Index SyntheticLikelihood::n_variables() const {
  const Eigen::Index n_blocks = std::ssize(observed_.blocks);
  return static_cast<Eigen::Index>(emulator_.basis().table.n_inputs()) +
         (terms_.has_discrepancy ? n_blocks : 0) + (terms_.has_specimen_scatter ? n_blocks : 0);
}

double SyntheticLikelihood::scale(Eigen::Index number, double variable) const {
  const std::size_t block = index(number) % observed_.blocks.size();
  return prior_scale_[block] * half_cauchy(variable);
}

Eigen::MatrixXd SyntheticLikelihood::shapes(const Eigen::VectorXd& variables, Eigen::Index first) const {
  const auto n_inputs = static_cast<Eigen::Index>(emulator_.basis().table.n_inputs());
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(observed_.mean.size(), observed_.mean.size());
  for (std::size_t k = 0; k < observed_.blocks.size(); ++k) {
    const QuantityBlock& block = observed_.blocks[k];
    const Eigen::Index number = first + static_cast<Eigen::Index>(k);
    sum.block(block.first, block.first, block.count, block.count) =
        std::pow(scale(number, variables[n_inputs + number]), 2) * block.shape;
  }
  return sum;
}

SyntheticLikelihood::Expected SyntheticLikelihood::expected(const Eigen::VectorXd& variables) const {
  auto [mean, leverage] = emulator_.predict(variables);
  const Eigen::Index n = mean.size();
  Eigen::MatrixXd single = scatter_ + observed_.error, all = Eigen::MatrixXd::Zero(n, n);
  if (terms_.has_discrepancy) all += shapes(variables, 0);
  if (terms_.has_specimen_scatter)
    single += shapes(variables, terms_.has_discrepancy ? std::ssize(observed_.blocks) : 0);
  // The bases are nested: two means have the terms of the lower degree in common.
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index k = 0; k < n; ++k)
      all(i, k) += std::min(leverage[i], leverage[k]) * shared_scatter_(i, k);
  all += observed_.share.cwiseProduct(single);
  all.diagonal() += least_variance_;
  return {std::move(mean), std::move(all)};
}

Likelihood SyntheticLikelihood::operator()(const Eigen::VectorXd& variables) const {
  const auto [mean, covariance] = expected(variables);
  const Eigen::LLT<Eigen::MatrixXd> factors(covariance);
  const double square = factors.matrixL().solve(observed_.mean - mean).squaredNorm();
  const auto n = static_cast<double>(mean.size());
  Likelihood found{log_t_density(square, log_determinant_of(factors), n, degrees_),
                   square + variables.squaredNorm()};
  if (!terms_.has_specimen_scatter) return found;
  Eigen::MatrixXd single = scatter_ + observed_.error +
                           shapes(variables, terms_.has_discrepancy ? std::ssize(observed_.blocks) : 0);
  single.diagonal() += least_variance_;
  const Eigen::LLT<Eigen::MatrixXd> own(single);
  for (Eigen::Index i = 0; i < observed_.contrasts.rows(); ++i)
    found.logarithm +=
        log_t_density(own.matrixL().solve(observed_.contrasts.row(i).transpose()).squaredNorm(),
                      log_determinant_of(own), n, degrees_);
  return found;
}

}  // namespace crackle::experiment
