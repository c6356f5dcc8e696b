// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/statistics.h"
#include "crackle/input/parameters.h"

#include <cstddef>
#include <optional>
#include <vector>

/// When an ensemble with [ensemble.stop] has enough samples: the mean path of the leading cracks
/// (Statistics::leader) is known. Whether and where a following crack arrives depends on how long the
/// computation goes on.
///
/// Looking at an interval again and again until it is narrow would make it too narrow: the sample at which it
/// looks best is chosen. So the error probability 1 - confidence is shared out beforehand over a fixed
/// schedule of looks (repeated confidence intervals, Jennison and Turnbull, J. R. Statist. Soc. B 51, 1989,
/// with Bonferroni's shares): looks are taken at min_samples and then each time the number of samples has
/// grown by half, the last one at ensemble.samples, and each uses Student's interval at the confidence
/// 1 - (1 - confidence) / looks. The intervals of all looks hold together with at least the given confidence
/// for each section, so the one at which the ensemble stops does, whatever made it stop. For positions with a
/// normal distribution this is exact at any number of samples; for others as exact as Student's interval is.
///
/// A look is over the samples with the numbers 0 to n - 1, once all of them have ended: which samples happen
/// to finish first plays no part.
namespace crackle::analysis {

/// A section counts for the rule when this share of the samples done has a leading crack there, and at least
/// two do.
inline constexpr double min_reached_share = 0.1;

/// The sample numbers n of the looks, ascending; the last one is `samples`.
std::vector<std::size_t> look_schedule(int samples, int min_samples);

/// What half width counts as enough where the input names none, as a share of the body's width.
inline constexpr double default_half_width_share = 0.01;

/// Number of the position in Statistics::leader (rows x sections) that counts and whose mean is known least;
/// nothing where none counts.
/// @param statistics as is_known
std::optional<std::size_t> least_certain(const Statistics& statistics);

/// How many samples it would take to know every section that counts, with the scatter seen so far; NaN where
/// none counts.
double n_samples_needed(const Statistics& statistics, double half_width);

/// Whether every section that counts is known well enough, and there is one.
/// @param statistics over the samples of one look, with the looks of the schedule
bool is_known(const Statistics& statistics, double half_width);

}  // namespace crackle::analysis
