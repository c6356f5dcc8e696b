// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"

#include <array>
#include <span>
#include <vector>

namespace crackle::analysis {

inline constexpr int n_patterns = 4;

/// Statistics over all samples done, summed in sample-number order so that they do not depend on the
/// schedule. Fields with shape notches x sections are row-major; a section that no sample reached has NaN.
struct Statistics {
  int n_notches = 0;
  int n_sections = 0;
  int n_samples = 0;  ///< rows of running_mean: all samples of the ensemble
  int n_done = 0;
  std::vector<double> z_mean;         ///< [m]
  std::vector<double> z_std;          ///< sample standard deviation (n - 1) [m]
  std::vector<double> z_half_width;   ///< of the confidence interval of the mean, Student's t [m]
  std::vector<std::int32_t> reached;  ///< number of samples whose crack arrived
  std::vector<double> running_mean;   ///< n_samples x notches x sections: mean over samples 0..i [m]
  std::array<double, n_patterns> pattern_share{};
  std::array<double, n_patterns> pattern_half_width{};  ///< Wilson interval's half width
};

Statistics make_statistics(std::span<const SampleSummary> samples, int n_notches, int n_sections,
                           double confidence = 0.95);

}  // namespace crackle::analysis
