// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_results.h"
#include "crackle/analysis/statistics.h"
#include "crackle/input/parameters.h"

#include <span>
#include <string>

namespace crackle::analysis {

/// The share of samples in which a result exceeds a limit, over the completed samples with this result, and
/// the samples that this share says nothing of.
struct Exceedance {
  ResultInfo info{};
  bool is_above = true;         ///< above the limit, rather than below
  double limit = not_a_number;  ///< [SI]
  int n_hits = 0;
  int n_values = 0;  ///< samples with this result
  int n_planned = 0;
  int n_failed = 0;
  int n_missing = 0;                              ///< not run yet
  int n_without = 0;                              ///< completed without this result
  int n_undecided = 0;                            ///< of those with it, still breaking when they ended
  double share = not_a_number;                    ///< n_hits of n_values
  Interval interval{not_a_number, not_a_number};  ///< of the share, by whole draws (share_interval)
};

/// @param condition such as "peak_load > 500 N": a result, > or <, and a value with its unit
/// @param rows of the samples that the ensemble needs
/// @throws std::runtime_error for an invalid condition, naming what is accepted
Exceedance exceedance(const std::string& condition, const input::Parameters& parameters,
                      std::span<const SampleSummary> rows, double confidence = default_confidence);

/// "peak_load > 500 N: 12 of 64 samples, 18.8 % (11.1 to 30.0 %)", and what the share leaves out.
std::string to_text(const Exceedance& exceedance);

}  // namespace crackle::analysis
