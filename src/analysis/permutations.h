// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace crackle::analysis {

/// Units whose labels "first" (0) and "second" (1) are exchangeable: samples, or whole draws of the random
/// inputs. For pairs, unit i has both labels, and label 1 swaps them; n_second is not used.
struct Design {
  std::size_t n_first = 0, n_second = 0;
  bool are_paired = false;

  std::size_t n_units() const { return are_paired ? n_first : n_first + n_second; }
};

using Labels = std::vector<std::uint8_t>;  ///< by unit: those of the first list, then those of the second
using LabelStatistic = std::function<double(const Labels&)>;

/// The labels that the units have.
Labels observed_labels(const Design& design);

/// Calls visit(labels) for each assignment of labels: for all, or for 9999 random ones if there are more than
/// 20,000; the same in every call.
/// @return true if all assignments were visited
bool for_each_labelling(const Design& design, const std::function<void(const Labels&)>& visit);

/// The smallest p-value that a two-sided test with these units can have.
double least_probability(const Design& design);

/// The share of assignments whose statistic is at least as large as the observed one, which is included.
double share_as_large(const Design& design, const LabelStatistic& statistic);

/// One of several tests with the same units.
struct Look {
  LabelStatistic statistic;  ///< at least 0
  bool is_distance = false;  ///< a squared distance, rather than a studentized difference
};

/// p-values adjusted for all looks by Westfall and Young's step-down max-T (1993, Resampling-Based Multiple
/// Testing, algorithm 2.8 for permutations): the labels of all looks change together, so looks that say the
/// same count once. Distances enter as roots relative to their mean square, like studentized differences.
std::vector<double> step_down_max_t(const Design& design, std::span<const Look> looks);

}  // namespace crackle::analysis
