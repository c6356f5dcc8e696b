// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"
#include "crackle/analysis/statistics.h"
#include "crackle/input/parameters.h"

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

/// What a result owes to one random input.
struct InputEffect {
  Estimate rank_correlation;  ///< Spearman's
  Estimate first;             ///< Sobol' index of first order: the share of the variance due to it alone
  Estimate total;             ///< of first order and of all interactions that it takes part in
};

/// What a result owes to the random inputs and to the mesh.
struct Sensitivity {
  ResultInfo info{};
  std::string share_of =
      {};            ///< "two cracks": of whether a sample is of this kind; empty for the number itself
  int notch = -1;    ///< of the position at a section; -1 for other results
  int section = -1;  ///< likewise
  int n_values = 0;  ///< samples that have the result
  /// Share of the variance that samples with the same draw have among each other: what the mesh alone and
  /// together with the inputs explains. NaN without replicates.
  Estimate mesh = {};
  int degree = 0;                        ///< of the chaos expansion
  double predicted = not_a_number;       ///< share of the variance that it predicts in draws left out
  std::vector<InputEffect> inputs = {};  ///< in the order of Parameters::random
};

struct Sensitivities {
  double confidence = default_confidence;
  int n_draws = 0;    ///< of the random inputs, with a sample that is done
  int n_samples = 0;  ///< that are done
  std::vector<Sensitivity> results = {};
};

/// What every result that differs between samples owes to the random inputs. Sobol' indices are shares of a
/// result's whole variance, that due to the mesh included. They come from a polynomial chaos expansion by
/// least squares, whose degree predicts draws left out best, less what scatter adds to its squared
/// coefficients (Sudret 2008, Reliab. Eng. Syst. Saf. 93, 964). Intervals are of 400 bootstrap samples of the
/// draws, the same in every call.
/// @param rows of the samples, with their inputs; those that are not done are left out
/// @return no results without random inputs, or with too few draws
Sensitivities sensitivities(const input::Parameters& parameters, std::span<const SampleSummary> rows,
                            double confidence = default_confidence);

/// As a table to read. Empty without results.
std::string to_text(const Sensitivities& sensitivities, const input::Parameters& parameters);

/// The share of samples in which a result passes a limit, with Wilson's interval for as many independent
/// samples as tell as much: samples of one draw are not independent.
struct Exceedance {
  ResultInfo info{};
  bool is_above = true;         ///< the limit, rather than below
  double limit = not_a_number;  ///< [SI]
  int n_hits = 0;
  int n_values = 0;
  Estimate share;
};

/// @param condition such as "peak_load > 500 N": a result, > or <, and a value with its unit
/// @throws std::runtime_error for a condition that cannot be read, with what is accepted
Exceedance exceedance(const std::string& condition, const input::Parameters& parameters,
                      std::span<const SampleSummary> rows, double confidence = default_confidence);

/// "peak_load > 500 N: 12 of 64 samples, 18.8 % (11.1 to 30.0 %)"
std::string to_text(const Exceedance& exceedance);

}  // namespace crackle::analysis
