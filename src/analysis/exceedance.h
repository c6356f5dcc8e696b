// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/censored_values.h"
#include "analysis/result_list.h"
#include "analysis/statistics.h"

#include <span>
#include <string>

namespace crackle::analysis {

/// The share of samples in which a result exceeds a limit, over the completed samples with this result, and
/// the samples that this share says nothing of. A load of an unbroken sample is known by a lower bound.
struct Exceedance {
  ResultInfo info{};
  bool is_above = true;         ///< above the limit, rather than below
  double limit = not_a_number;  ///< [SI]
  CensoredShare share{};        ///< of n_values, by whole draws
  int n_values = 0;             ///< samples with this result
  int n_bounds = 0;             ///< of these, unbroken ones, of which only a lower bound is known
  int n_planned = 0;
  int n_failed = 0;
  int n_missing = 0;    ///< not run yet
  int n_without = 0;    ///< completed without this result
  int n_undecided = 0;  ///< of those with it, still breaking when they ended
};

/// @param condition such as "peak_load > 500 N": a result, > or <, and a value with its unit
/// @param rows of the samples that the ensemble needs
/// @param replicates samples with the same draw of the random inputs
/// @throws std::runtime_error for an invalid condition, naming what is accepted
Exceedance exceedance(const std::string& condition, std::span<const SampleSummary> rows, int replicates = 1,
                      double confidence = default_confidence);

/// "peak_load > 500 N: 12 of 64 samples, 18.8 % (11.1 to 30.0 %)", and what the share estimates or leaves
/// out.
std::string to_text(const Exceedance& exceedance);

}  // namespace crackle::analysis
