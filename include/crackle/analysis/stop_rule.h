// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/statistics.h"
#include "crackle/input/parameters.h"

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
/// A look uses the samples 0 to n - 1 once all of them have ended, so the order in which samples finish has
/// no influence.
namespace crackle::analysis {

/// A section counts for the rule if this share of the completed samples, and at least two, have a leading
/// crack there.
inline constexpr double min_reached_share = 0.1;

/// The sample numbers n of the looks, ascending; the last one is `samples`.
std::vector<std::size_t> look_schedule(int samples, int min_samples);

/// Default of the required half width, as a share of the body's width.
inline constexpr double default_half_width_share = 0.01;

/// Index of the counting position in Statistics::leader (rows x sections) whose mean is least certain; empty
/// if none counts.
/// @param statistics as is_known
std::optional<std::size_t> least_certain(const Statistics& statistics);

/// Number of samples needed to know every counting section well enough, given the scatter so far; NaN if none
/// counts.
double n_samples_needed(const Statistics& statistics, double half_width);

/// True if at least one section counts and all that count are known well enough.
/// @param statistics over the samples of one look, with the looks of the schedule
bool is_known(const Statistics& statistics, double half_width);

}  // namespace crackle::analysis
