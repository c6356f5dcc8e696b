// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/grouped_values.h"
#include "analysis/sample_summary.h"
#include "analysis/statistics.h"
#include "input/study.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

/// Several ensembles of one input, each with its own base of mother points that its samples share. Samples of
/// a base are a cluster; what holds for the material is seen between bases.
namespace crackle::analysis {

/// One of them.
struct BaseSamples {
  const input::Study* study;
  std::vector<std::string> settings;  ///< input::sample_settings with 0 for the seed, in which bases differ
  std::span<const SampleSummary> rows;
  Origin origin = {};
};

/// A mean with its confidence interval.
struct BoundedMean {
  double value = not_a_number;
  double lower = not_a_number;  ///< NaN if there are too few values, or equal ones only
  double upper = not_a_number;
  bool has_no_width = false;  ///< the values are equal, so that they give no interval
};

/// A mean over bases with its interval: of the bases' means, or where these agree of the scatter within
/// bases, Student's t with one degree of freedom less than bases; with the variance within and between them
/// (nested analysis of variance).
struct MeanOverBases {
  ResultInfo info{};
  std::string share_of = {};         ///< category whose share it is; empty for the number itself
  int start = -1;                    ///< for the position of the leading crack: the start of its class
  int section = -1;                  ///< likewise
  std::vector<double> of_base = {};  ///< mean of each base; NaN without values
  int n_values = 0;                  ///< samples of all bases
  bool is_divided = false;           ///< a position where cracks of all bases form groups (path_groups.h)
  BoundedMean mean = {};             ///< of the bases' means, with its interval
  VarianceComponents variance = {};
};

struct BasesStatistics {
  double confidence = default_confidence;
  std::vector<std::uint64_t> seeds = {};
  std::vector<int> n_done = {};  ///< of each base
  int n_failed = 0, n_pending = 0, n_undecided = 0, n_unbroken = 0, n_held = 0;
  std::vector<MeanOverBases> results = {};
};

/// @throws std::runtime_error unless there are at least two ensembles, each with a shared base, whose inputs
///   differ in the seed only
BasesStatistics statistics_of_bases(std::span<const BaseSamples> bases,
                                    double confidence = default_confidence);

/// As a readable table.
std::string to_text(const BasesStatistics& statistics, const input::Sections& sections);

/// As a JSON document; NaN is null.
std::string to_json(const BasesStatistics& statistics, std::span<const std::string> folders,
                    const input::Sections& sections);

}  // namespace crackle::analysis
