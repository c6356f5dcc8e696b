// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/sample_summary.h"
#include "analysis/statistics.h"
#include "input/study.h"

#include <span>
#include <string>
#include <vector>

namespace crackle::analysis {

/// A number with its confidence interval.
struct Estimate {
  double value = not_a_number;
  double lower = not_a_number;
  double upper = not_a_number;
};

/// Effect of one random input on a result.
struct InputEffect {
  Estimate rank_correlation;  ///< Spearman's
  Estimate first;             ///< first-order Sobol' index: the share of the variance due to this input alone
  Estimate total;             ///< total Sobol' index: first order plus all interactions of this input
};

/// Effects of the random inputs and of the mesh on a result.
struct Sensitivity {
  ResultInfo info{};
  std::string share_of =
      {};  ///< category, such as "two cracks", whose occurrence is analysed; empty for the number itself
  int start = -1;    ///< for the position at a section; -1 for other results
  int section = -1;  ///< likewise
  int n_values = 0;  ///< number of samples with this result
  int n_draws = 0;   ///< of these samples
  int n_bounds = 0;  ///< of the values: known to lie above a load that the sample bore
  /// Share of the variance among samples with the same draw: explained by the mesh alone and together with
  /// the inputs. NaN without replicates.
  Estimate mesh = {};
  int degree = 0;                   ///< of the chaos expansion
  double predicted = not_a_number;  ///< share of the variance predicted in cross-validation
  /// Share of the variance due neither to the mesh nor predicted: what the polynomials cannot follow, as
  /// where a result jumps. NaN without replicates.
  double lack_of_fit = not_a_number;
  std::vector<InputEffect> inputs = {};  ///< in the order of Study::random
};

/// Lack of fit above which the indices of a result are not to be relied on.
inline constexpr double large_lack_of_fit = 0.2;

struct Sensitivities {
  double confidence = default_confidence;
  int n_draws = 0;    ///< random draws with at least one completed sample
  int n_samples = 0;  ///< completed samples
  /// Where in the ranges of the inputs the draws lie that fail, as sentences; empty unless they lie elsewhere
  /// than the others (p below 0.01 of Wilcoxon's rank-sum test, times the number of inputs).
  std::string failures = {};
  std::vector<Sensitivity> results = {};
};

/// Effects of the random inputs on every result that varies between samples. Sobol' indices are shares of a
/// result's total variance, including that due to the mesh, among the draws that have the result. Loads of
/// samples that did not break are drawn above the largest applied, unless these are more than half. They come
/// from a least-squares polynomial chaos expansion, whose degree minimizes the cross-validation error; inputs
/// share what it explains by their squared coefficients, corrected for the bias due to scatter (Sudret 2008,
/// Reliab. Eng. Syst. Saf. 93, 964). Intervals are from 400 bootstrap samples of the draws, the same in every
/// call. With correlated inputs first and total are NaN.
/// @param rows of the samples, with their inputs; samples that are not done are ignored
/// @return no results without random inputs, or with too few draws
Sensitivities sensitivities(const input::Study& study, std::span<const SampleSummary> rows,
                            double confidence = default_confidence);

/// How intervals and p-values that assume independent draws err with draws that lie more evenly. Empty if
/// they hold.
std::string note_on_plan(const input::Study& study);

/// As a readable table; empty without results.
std::string to_text(const Sensitivities& sensitivities, const input::Study& study);

}  // namespace crackle::analysis
