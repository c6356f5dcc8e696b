// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"
#include "crackle/input/parameters.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace crackle::analysis {

inline constexpr int n_patterns = 4;
inline constexpr double default_confidence = 0.95;

/// Statistics over all samples done, summed in sample-number order so that they do not depend on the
/// schedule. Fields with shape notches x sections are row-major and count the samples whose crack arrived; a
/// section that no sample reached has NaN.
struct Statistics {
  int n_notches = 0;
  int n_sections = 0;
  int n_samples = 0;  ///< rows of running_mean: all samples of the ensemble
  int n_done = 0;
  double confidence = default_confidence;  ///< of the intervals below
  std::vector<double> z_mean;              ///< [m]
  std::vector<double> z_std;               ///< sample standard deviation (n - 1) [m]; NaN for fewer than two
  std::vector<double> z_half_width;   ///< of the confidence interval of the mean, Student's t [m]; likewise
  std::vector<std::int32_t> reached;  ///< number of samples whose crack arrived
  std::vector<double> running_mean;   ///< n_samples x notches x sections: mean over samples 0..i [m]
  std::array<double, n_patterns> pattern_share{};       ///< NaN when no sample is done
  std::array<double, n_patterns> pattern_half_width{};  ///< Wilson interval's half width; likewise
};

/// @param samples one row for each sample of the ensemble, in the order of their numbers
/// @throws std::invalid_argument when a row has another shape or `confidence` is not between 0 and 1
Statistics make_statistics(std::span<const SampleSummary> samples, int n_notches, int n_sections,
                           double confidence = default_confidence);

/// As above, for the notches and sections of the input, at the confidence that its [ensemble.stop] asks for
/// (default_confidence without): the statistics of its ensemble.h5.
Statistics make_statistics(std::span<const SampleSummary> samples, const input::Parameters& parameters);

/// The value below which a share of the values lies, linear between neighbours in rank (Hyndman and Fan's
/// type 7). NaN values are left out; NaN when none is left.
double quantile(std::vector<double> values, double share);

/// The statistics as a table to read: crack positions, patterns, onset, samples that failed.
std::string to_text(const Statistics& statistics, std::span<const SampleSummary> samples,
                    std::span<const double> sections);

}  // namespace crackle::analysis
