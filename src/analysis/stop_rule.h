// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/statistics.h"
#include "input/study.h"

#include <cstddef>
#include <optional>
#include <vector>

/// The stopping rule of an ensemble with [ensemble.stop]: the mean path of the leading cracks
/// (Statistics::leader) is known well enough. Following cracks are excluded, as their arrival depends on the
/// duration of the computation.
///
/// Checking an interval repeatedly until it is narrow enough would bias it, since the most favourable sample
/// size is selected. Therefore the error probability 1 - confidence is divided beforehand over a fixed
/// schedule of looks (repeated confidence intervals, Jennison and Turnbull, J. R. Statist. Soc. B 51, 1989,
/// with Bonferroni's correction): at min_samples, then each time the number of samples has grown by half, and
/// finally at ensemble.samples; each look uses Student's interval at the confidence 1 - (1 - confidence) /
/// looks. Jointly, the intervals of all looks have at least the given confidence for each section, hence so
/// has the one at which the ensemble stops, for whatever reason. For normally distributed positions this
/// holds at any number of samples; for others as accurately as Student's interval.
///
/// Where the leaders of a class take several paths (path_groups.h), the rule speaks of the mean of each group
/// that holds at least min_group_share of them: the mean of all is no crack's position, and its scatter does
/// not fall below the distance between the paths. A smaller group is told by its share alone: its mean would
/// take more than 1 / min_group_share times as many samples.
///
/// A look uses the samples 0 to n - 1 once all of them have ended, so the order in which samples finish has
/// no influence.
namespace crackle::analysis {

/// A section counts for the rule if this share of the completed samples, and at least two, have a leading
/// crack there, of a group where the leaders take several paths.
inline constexpr double min_reached_share = 0.1;

/// A group of samples counts for the rule if it holds this share of those of its class.
inline constexpr double min_group_share = 0.2;

/// A mean position that counts for the rule.
struct LeaderMean {
  std::size_t position = 0;          ///< index in Statistics::leader, rows x sections
  const PathGroup* group = nullptr;  ///< whose mean it is, of the statistics; null where all take one path
  int n = 0;                         ///< samples with a position there
  double deviation = not_a_number;   ///< standard deviation of their positions [m]
  double half_width = not_a_number;  ///< of the mean's confidence interval [m]
};

/// The sample numbers n of the looks, ascending; the last one is `samples`.
std::vector<std::size_t> look_schedule(int samples, int min_samples);

/// Default of the required half width, as a share of the body's width.
inline constexpr double default_half_width_share = 0.01;

/// The counting mean that is least certain, first of all one without half width; empty if none counts.
/// @param statistics as is_known
std::optional<LeaderMean> least_certain(const Statistics& statistics);

/// Number of samples needed to know every counting mean well enough, given the scatter so far; NaN if none
/// counts, or one has no half width.
double n_samples_needed(const Statistics& statistics, double half_width);

/// True if at least one mean counts and all that count are known well enough.
/// @param statistics over the samples of one look, with the looks of the schedule
bool is_known(const Statistics& statistics, double half_width);

}  // namespace crackle::analysis
