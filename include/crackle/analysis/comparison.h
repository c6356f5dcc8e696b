// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"
#include "crackle/analysis/statistics.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace crackle::analysis {

/// A difference with its confidence interval.
struct Difference {
  double value = not_a_number;
  double lower = not_a_number;  ///< NaN if there are too few values
  double upper = not_a_number;
};

/// Two lists of values; if paired, value i of one belongs to value i of the other.
struct TwoSamples {
  std::vector<double> first, second;
  bool are_paired = false;
};

/// Difference of the means, second minus first: Welch's interval or, for pairs, Student's interval of the
/// differences.
Difference difference_of_means(const TwoSamples& samples, double confidence);

/// Difference of the medians or, for pairs, median of the differences: percentiles of 4000 bootstrap samples,
/// the same in every call.
Difference difference_of_medians(const TwoSamples& samples, double confidence);

/// Difference of the shares of values equal to 1, all being 0 or 1: Newcombe's intervals from Wilson's, for
/// independent (Newcombe 1998, Stat. Med. 17, 873, method 10) and for paired shares (Newcombe 1998, Stat.
/// Med. 17, 2635, method 10).
Difference difference_of_shares(const TwoSamples& samples, double confidence);

/// Two-sided p-value of the difference of the means, studentized (Welch's statistic or, for pairs, Student's
/// of the differences), under random assignment of the labels "first" and "second": over all assignments, or
/// over 9999 random ones if there are more than 20,000. Valid for samples of any size. 1 if there is nothing
/// to compare.
double permutation_probability(const TwoSamples& samples);

/// Two groups of crack paths, each given by its positions at the sections; NaN if the crack did not arrive.
struct TwoGroupsOfPaths {
  std::vector<std::vector<double>> first, second;
  bool are_paired = false;
};
struct EnergyDistance {
  double value = not_a_number;  ///< in the units of the positions
  double probability = 1;       ///< p-value by permutations as above
};
/// Energy distance of the distributions of the paths (Székely and Rizzo 2004): 2 E|X - Y| - E|X - X'| - E|Y -
/// Y'|, where the distance of two paths is the root mean square over the sections that both reach; pairs of
/// paths without a common section are left out. For paired samples, between the differences and their mirror
/// images.
EnergyDistance energy_distance(const TwoGroupsOfPaths& paths);

/// Holm's adjustment of p-values for multiple comparisons: the chance of any false value below 0.05 is at
/// most 5 %. NaN is not counted as a comparison.
std::vector<double> adjusted_for_comparisons(std::span<const double> probabilities);

/// Comparison of one number or share.
struct ComparedResult {
  ResultInfo info{};
  std::string share_of;  ///< category, such as "two cracks" or "any", whose share is compared; empty for the
                         ///< number itself
  int n_first = 0, n_second = 0;
  double mean_first = not_a_number, mean_second = not_a_number;  ///< or shares
  Difference of_means = {};
  Difference of_medians = {};  ///< not for shares
  double probability = 1, adjusted = 1;
};

/// Comparison of the paths of the leading cracks, by class (LeaderFrame).
struct ComparedPaths {
  int leading_start = 0;
  int n_first = 0, n_second = 0;
  EnergyDistance distance;
  double adjusted = 1;
  std::vector<Difference> of_means;  ///< at each section [m]
};

struct Comparison {
  bool are_paired = false;
  std::string note;  ///< why samples are not paired or paths not compared; may be empty
  int n_pairs = 0;
  double confidence = default_confidence;
  std::vector<ComparedResult> results;
  std::vector<ComparedPaths> paths;
};

/// An ensemble to compare.
struct Compared {
  const input::Parameters* parameters;
  std::span<const SampleSummary> rows;
  Origin origin = {};
};

/// Compares the completed samples of two ensembles: in pairs if both have the same bodies sample by sample,
/// otherwise as independent. p-values are adjusted for all comparisons made.
Comparison compare(const Compared& first, const Compared& second, double confidence = default_confidence);

/// The comparison as readable tables.
/// @param first, second names
std::string to_text(const Comparison& comparison, const std::string& first, const std::string& second,
                    const input::Sections& sections);

/// Comparisons of several ensembles with the first one, as a JSON document; NaN is null.
std::string to_json(std::span<const Comparison> comparisons, std::span<const std::string> names,
                    const input::Sections& sections);

}  // namespace crackle::analysis
