// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/running_statistics.h"
#include "analysis/statistics.h"

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

/// Means, shares and medians of values that come in groups: the meshes of one draw of the random inputs, or
/// the samples of one base. Values of a group are alike; groups are independent.
namespace crackle::analysis {

/// Group of each value, in ascending order; empty if each value is a group of its own.
using Groups = std::span<const std::size_t>;

/// The group of value i.
inline std::size_t group_of(Groups groups, std::size_t i) {
  return groups.empty() ? i : groups[i];
}

/// Components of the variance by one-way random-effects analysis of variance (Searle, Casella and McCulloch
/// 1992, Variance Components, chapter 3).
struct VarianceComponents {
  int n_groups = 0;
  double within = not_a_number;         ///< variance within groups; NaN if no group has several values
  double between = not_a_number;        ///< variance of the groups' true means, at least 0
  double intraclass = not_a_number;     ///< between over the sum of both; NaN if all values are equal
  double design_effect = not_a_number;  ///< variance of the mean over that of as many independent values
};

/// @param times multiplicity of each value, equal within groups; empty: 1
VarianceComponents variance_components(std::span<const double> values, Groups groups,
                                       std::span<const double> times = {});

/// Mean of values added in the order of their groups, with its standard error by the sums of residuals in
/// groups (linearization; Cochran 1977, Sampling Techniques, section 9A): valid however alike the values of a
/// group are.
class GroupedMoments {
public:
  void add(double value, std::size_t group);
  int n_groups() const { return n_groups_; }
  double mean() const;
  double square_error() const;  ///< of the mean; NaN for fewer than two groups

private:
  void close_group();

  std::size_t group_ = std::numeric_limits<std::size_t>::max();
  int n_groups_ = 0;
  double origin_ = 0;  ///< the first value: the sums below are of differences from it
  double n_ = 0, sum_ = 0;
  double own_n_ = 0, own_sum_ = 0;                         ///< of the last group
  double squares_n_ = 0, squares_sum_ = 0, products_ = 0;  ///< sums over the groups before
};

/// Mean and scatter of values, with the interval of the mean by Student's t: of as many independent values,
/// or by whole groups.
MeanEstimate mean_estimate(std::span<const double> values, Groups groups, double confidence);

/// Number of independent values that know a share as well as these (Kish's design effect).
/// @param values all 0 or 1, at least one
double independent_values(std::span<const double> values, Groups groups);

/// Wilson's interval of the share of values that are 1 for independent_values of them.
Interval share_interval(std::span<const double> values, Groups groups, double confidence);

/// Confidence interval of the median. For independent values between order statistics, exact for every
/// continuous distribution by the binomial distribution (Conover 1999, Practical Nonparametric Statistics,
/// section 3.2); of differences, it is that of the sign test. For groups by Woodruff's method (1952, J. Am.
/// Stat. Assoc. 47, 635), with Student's t for the number of groups, or from the least to the largest value.
/// NaN is ignored; NaN ends if there are fewer than least_values_for_median groups.
Interval median_interval(std::span<const double> values, Groups groups, double confidence);

/// Fewer independent values have no interval of the median: 6 at 95 %.
int least_values_for_median(double confidence);

}  // namespace crackle::analysis
