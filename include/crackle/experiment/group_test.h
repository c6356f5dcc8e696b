// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/bases.h"
#include "crackle/common/real.h"
#include "crackle/experiment/distances.h"

#include <cstddef>
#include <cstdint>

/// Tests of several experiments against samples.
namespace crackle::experiment {

/// p-values by permutation of what is an experiment and what a sample.
struct GroupTest {
  /// Energy distance (Székely and Rizzo 2004), 2 E|X - Y| - E|X - X'| - E|Y - Y'|: sees any difference of the
  /// distributions.
  double energy = not_a_number;
  double energy_p_value = 1;
  /// Rank sum of the experiments by mean distance to all others, a depth (Liu and Singh 1993): sees
  /// experiments that lie farther out than the samples.
  double depth_p_value = 1;
  std::int64_t n_permutations = 0;
  bool are_all = false;  ///< every permutation, not random ones

  /// Both tests as one (Bonferroni).
  double p_value() const;
};

/// The most permutations that are tried one by one, and the number of random ones if there are more.
inline constexpr double max_exact_permutations = 20'000;
inline constexpr std::int64_t n_random_permutations = 9'999;

/// @param distances with the experiments first
/// @param n_experiments at least 1 and less than the rows
/// @param n_random random permutations, the same in each call with the same numbers of rows
GroupTest group_test(const Distances& distances, std::size_t n_experiments,
                     std::int64_t n_random = n_random_permutations);

/// How often group_test, at a p-value of 0.05 or less, finds a difference in pseudo-experiments: samples
/// taken out at random, and changed.
struct Power {
  double of_shift = not_a_number;    ///< by one standard deviation, along the whole path
  double of_scatter = not_a_number;  ///< twice that of the samples
  int n_trials = 0;
};

/// @param samples alone
/// @return n_trials 0 with fewer than n_experiments + 2 samples, or without scatter
Power power(const ValueTable& samples, std::size_t n_experiments, int n_trials);

/// How experiments differ from samples: by a shift, and in scatter.
struct Scatter {
  std::size_t n_experiments = 0, n_samples = 0;  ///< that count: those with a value in all columns that count
  std::size_t n_columns = 0;                     ///< that count
  /// Mean over the columns of the mean of the experiments less that of the samples, with Welch's interval.
  analysis::BoundedMean shift = {};
  /// Standard deviation of the experiments, without the error of reading them, over that of the samples:
  /// sqrt((V_e - error^2) / V_s), where V is the variance averaged over the columns. The interval is from F
  /// with (m - 1) v and (n - 1) v degrees of freedom, v = tr^2 S / tr S^2 for the covariance S (Box 1954).
  analysis::BoundedMean ratio = {};
  double degrees = not_a_number;  ///< v
};

/// Columns that an experiment, or more than a tenth of the samples, does not reach do not count.
/// @param samples without errors of reading
/// @param error standard deviation of the error of reading the experiments
/// @param confidence of the intervals
Scatter scatter(const ValueTable& experiments, const ValueTable& samples, double error, double confidence);

}  // namespace crackle::experiment
