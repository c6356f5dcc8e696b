// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/random.h"

#include <Eigen/Dense>
#include <cstddef>
#include <functional>
#include <vector>

namespace crackle::experiment {

/// The likelihood at a point.
struct Likelihood {
  double logarithm = 0;
  /// Square of the observations' distance from what is expected there, in standard deviations, plus that of
  /// the point from the middle of the prior.
  double squared_distance = 0;
};

struct SamplingEffort {
  std::size_t population = 2000;
  double wanted_size = 4000;  ///< effective size at which sampling ends
  int most_populations = 20;
};

/// Weighted points of a posterior.
struct PosteriorPoints {
  std::vector<Eigen::VectorXd> point = {};  ///< independent standard normal a priori
  Eigen::VectorXd weight = {};              ///< sum 1
  double effective_size = 0;                ///< 1 / sum of squared weights
  double bits = 0;                          ///< Kullback-Leibler divergence of the posterior from the prior
  double least_squared_distance = 0;
};

/// Adaptive importance sampling: populations from a mixture of t distributions that is fitted to all earlier
/// points, weighted as if all came from the mixture of all proposals (Cappé et al. 2004, J. Comput. Graph.
/// Stat. 13, 907; Cornuet et al. 2012, Scand. J. Stat. 39, 798). While weights are too uneven for a fit, it
/// is to a power of the likelihood. The same in each call.
PosteriorPoints sample_posterior(Eigen::Index n_variables,
                                 const std::function<Likelihood(const Eigen::VectorXd&)>& likelihood,
                                 const SamplingEffort& effort, const RandomStream& stream);

}  // namespace crackle::experiment
