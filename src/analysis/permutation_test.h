// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

namespace crackle::analysis {

/// Two lists of values.
struct TwoSamples {
  std::vector<double> first, second;
  /// Group of each value, such as its draw of the random inputs, in ascending order; empty if values are
  /// independent. Groups of both lists are independent.
  std::vector<std::size_t> first_group = {}, second_group = {};
};

/// Two-sided p-value of the difference of the means, studentized (Welch's statistic), under random assignment
/// of the labels "first" and "second": over all assignments, or over 9999 random ones if there are more than
/// 20,000; the same in every call. Groups are assigned as wholes. Valid for samples of any size. 1 if there
/// is nothing to compare.
double permutation_probability(const TwoSamples& samples);

}  // namespace crackle::analysis
