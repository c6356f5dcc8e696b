// SPDX-License-Identifier: GPL-3.0-or-later
#include "importance_sampling.h"

#include "crackle/common/index.h"
#include "crackle/common/real.h"
#include "crackle/experiment/path_frame.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace crackle::experiment {

namespace {

/// Degrees of freedom of a proposal's t distributions.
constexpr int t_degrees = 6;
constexpr Eigen::Index n_clusters = 3;
constexpr int n_fit_steps = 5;
/// A fit leaves points out that weigh less than this share of the mean.
constexpr double least_weight = 1e-2;
/// Shares of proposals that keep weights bounded: one as wide as the prior, one wider than the posterior.
constexpr double prior_share = 0.05, wide_share = 0.15;
constexpr double wide_factor = 2;
/// Effective size that a fit needs, for each variable.
constexpr double size_per_variable = 20;

double log_of_sum(double a, double b) {
  const double larger = std::max(a, b);
  return std::isinf(larger) ? larger : larger + std::log1p(std::exp(std::min(a, b) - larger));
}

/// A multivariate t distribution.
struct Component {
  double log_weight = 0;
  Eigen::VectorXd mean;
  Eigen::MatrixXd factor;  ///< lower triangle; factor factor^T is the covariance of the normal part

  double log_density(const Eigen::VectorXd& x) const {
    const auto n = static_cast<double>(mean.size());
    const double square = factor.triangularView<Eigen::Lower>().solve(x - mean).squaredNorm();
    return std::lgamma((t_degrees + n) / 2) - std::lgamma(t_degrees / 2.0) -
           n / 2 * std::log(t_degrees * std::numbers::pi) - factor.diagonal().array().log().sum() -
           (t_degrees + n) / 2 * std::log1p(square / t_degrees);
  }
};

using Mixture = std::vector<Component>;

double log_density(const Mixture& mixture, const Eigen::VectorXd& x) {
  double sum = -infinity;
  for (const Component& each : mixture) sum = log_of_sum(sum, each.log_weight + each.log_density(x));
  return sum;
}

Eigen::VectorXd normals(Eigen::Index n, RandomStream& stream) {
  Eigen::VectorXd x(n);
  for (double& each : x) each = stream.normal();
  return x;
}

Eigen::VectorXd draw(const Mixture& mixture, RandomStream stream) {
  double left = stream.uniform();
  std::size_t k = 0;
  while (k + 1 < mixture.size() && left >= std::exp(mixture[k].log_weight))
    left -= std::exp(mixture[k++].log_weight);
  const double width = std::sqrt(t_degrees / normals(t_degrees, stream).squaredNorm());
  return mixture[k].mean + width * (mixture[k].factor * normals(mixture[k].mean.size(), stream));
}

/// Mean and covariance of weighted points.
Component moments(const std::vector<Eigen::VectorXd>& points, const Eigen::VectorXd& weight,
                  const Eigen::MatrixXd& least_covariance) {
  const Eigen::Index n = points.front().size();
  Component found{0, Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, n)};
  const double sum = std::max(weight.sum(), 1e-300);
  for (std::size_t i = 0; i < points.size(); ++i)
    found.mean += weight[static_cast<Eigen::Index>(i)] / sum * points[i];
  Eigen::MatrixXd covariance = least_covariance;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double share = weight[static_cast<Eigen::Index>(i)] / sum;
    if (share > 0) covariance.selfadjointView<Eigen::Lower>().rankUpdate(points[i] - found.mean, share);
  }
  found.factor = Eigen::LLT<Eigen::MatrixXd>(covariance).matrixL();
  found.log_weight = std::log(sum);
  return found;
}

/// Shares of each point in clusters of equal weight along the widest direction.
Eigen::MatrixXd first_clusters(const std::vector<Eigen::VectorXd>& points, const Eigen::VectorXd& weight,
                               const Component& all) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(all.factor * all.factor.transpose());
  const Eigen::VectorXd widest = axes.eigenvectors().rightCols(1);
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return widest.dot(points[i]); });
  Eigen::MatrixXd share = Eigen::MatrixXd::Zero(std::ssize(points), n_clusters);
  double sum = 0;
  for (const std::size_t i : order) {
    const auto row = static_cast<Eigen::Index>(i);
    share(row, std::min(n_clusters - 1, static_cast<Eigen::Index>(sum * n_clusters))) = 1;
    sum += weight[row];
  }
  return share;
}

/// A mixture like weighted points, by expectation maximization.
/// @param all_weights sum 1
Mixture fitted(const std::vector<Eigen::VectorXd>& all_points, const Eigen::VectorXd& all_weights) {
  const Eigen::Index n = all_points.front().size();
  std::vector<Eigen::VectorXd> points;
  std::vector<Eigen::Index> kept;
  for (std::size_t i = 0; i < all_points.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (all_weights[row] * static_cast<double>(all_points.size()) < least_weight) continue;
    points.push_back(all_points[i]);
    kept.push_back(row);
  }
  const Eigen::VectorXd weight = all_weights(kept) / all_weights(kept).sum();
  Component all = moments(points, weight, 1e-10 * Eigen::MatrixXd::Identity(n, n));
  const Eigen::MatrixXd least = 0.02 * all.factor * all.factor.transpose();
  Eigen::MatrixXd share = first_clusters(points, weight, all);
  Mixture mixture;
  for (int step = 0; step < n_fit_steps; ++step) {
    mixture.clear();
    for (Eigen::Index k = 0; k < n_clusters; ++k)
      mixture.push_back(moments(points, weight.cwiseProduct(share.col(k)), least));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const double density = log_density(mixture, points[i]);
      for (Eigen::Index k = 0; k < n_clusters; ++k)
        share(row, k) =
            std::exp(mixture[index(k)].log_weight + mixture[index(k)].log_density(points[i]) - density);
    }
  }
  for (Component& each : mixture) each.log_weight += std::log(1 - prior_share - wide_share);
  all.factor *= std::sqrt(wide_factor);
  all.log_weight = std::log(wide_share);
  mixture.push_back(std::move(all));
  mixture.push_back({std::log(prior_share), Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Identity(n, n)});
  return mixture;
}

/// All points so far.
struct Points {
  std::vector<Eigen::VectorXd> point;
  std::vector<double> log_likelihood, log_prior;
  std::vector<double> log_proposal;  ///< log of the sum of all proposals times their numbers of points
  double least_squared_distance = infinity;

  /// Weights for the prior times a power of the likelihood; sum 1.
  /// @return log of their sum before, the evidence, too
  std::pair<Eigen::VectorXd, double> weights(double power) const {
    Eigen::VectorXd weight(std::ssize(point));
    for (std::size_t i = 0; i < point.size(); ++i)
      weight[static_cast<Eigen::Index>(i)] = log_prior[i] + power * log_likelihood[i] - log_proposal[i];
    const double largest = weight.maxCoeff();
    weight = (weight.array() - largest).exp();
    const double sum = weight.sum();
    return {weight / sum, largest + std::log(sum)};
  }

  /// Largest power for which the weights have this effective size.
  double power_for(double size) const {
    const auto is_enough = [&](double power) { return 1 / weights(power).first.squaredNorm() >= size; };
    if (is_enough(1)) return 1;
    double lower = 0, upper = 1;
    for (int step = 0; step < 30; ++step) {
      const double middle = (lower + upper) / 2;
      (is_enough(middle) ? lower : upper) = middle;
    }
    return lower;
  }
};

void add_population(const std::vector<Mixture>& proposals,
                    const std::function<Likelihood(const Eigen::VectorXd&)>& likelihood, std::size_t size,
                    const RandomStream& stream, Points& all) {
  const double log_size = std::log(static_cast<double>(size));
  for (std::size_t i = 0; i < all.point.size(); ++i)
    all.log_proposal[i] =
        log_of_sum(all.log_proposal[i], log_size + log_density(proposals.back(), all.point[i]));
  for (std::size_t i = 0; i < size; ++i) {
    Eigen::VectorXd x = draw(proposals.back(), stream.substream(i));
    double proposal = -infinity;
    for (const Mixture& each : proposals) proposal = log_of_sum(proposal, log_size + log_density(each, x));
    const Likelihood found = likelihood(x);
    all.log_proposal.push_back(proposal);
    all.log_likelihood.push_back(found.logarithm);
    all.log_prior.push_back(-x.squaredNorm() / 2 -
                            static_cast<double>(x.size()) / 2 * std::log(2 * std::numbers::pi));
    all.least_squared_distance = std::min(all.least_squared_distance, found.squared_distance);
    all.point.push_back(std::move(x));
  }
}

}  // namespace

PosteriorPoints sample_posterior(Eigen::Index n_variables,
                                 const std::function<Likelihood(const Eigen::VectorXd&)>& likelihood,
                                 const SamplingEffort& effort, const RandomStream& stream) {
  std::vector<Mixture> proposals{
      {{0, Eigen::VectorXd::Zero(n_variables), Eigen::MatrixXd::Identity(n_variables, n_variables)}}};
  Points all;
  for (int k = 0; k < effort.most_populations; ++k) {
    if (k > 0) {
      const double power = all.power_for(size_per_variable * static_cast<double>(n_variables));
      const Eigen::VectorXd weight = all.weights(power).first;
      if (power == 1 && 1 / weight.squaredNorm() >= effort.wanted_size) break;
      proposals.push_back(fitted(all.point, weight));
    }
    add_population(proposals, likelihood, effort.population, stream.substream(static_cast<std::uint64_t>(k)),
                   all);
  }
  auto [weight, log_evidence] = all.weights(1);
  double mean = 0;
  for (std::size_t i = 0; i < all.point.size(); ++i)
    if (weight[static_cast<Eigen::Index>(i)] > 0)
      mean += weight[static_cast<Eigen::Index>(i)] * all.log_likelihood[i];
  PosteriorPoints found{.effective_size = 1 / weight.squaredNorm(),
                        .bits = (mean - log_evidence) / std::numbers::ln2,
                        .least_squared_distance = all.least_squared_distance};
  found.weight = std::move(weight);
  found.point = std::move(all.point);
  return found;
}

}  // namespace crackle::experiment
