// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/censored_values.h"
#include "crackle/analysis/sample_summary.h"
#include "crackle/analysis/statistics.h"
#include "crackle/input/parameters.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace crackle::analysis {

inline constexpr double significant = 0.05;  ///< p-values up to this count as significant

/// A difference with its confidence interval.
struct Difference {
  double value = not_a_number;
  double lower = not_a_number;  ///< NaN if there are too few values, or equal ones only
  double upper = not_a_number;
  bool has_no_width = false;  ///< the values are equal, so that they give no interval
};

/// Two lists of values; if paired, value i of one belongs to value i of the other.
struct TwoSamples {
  std::vector<double> first, second;
  bool are_paired = false;
  /// Group of each value, such as its draw of the random inputs, in ascending order; empty if values are
  /// independent. Groups of both lists are independent; for pairs, the first list's hold for both.
  std::vector<std::size_t> first_group = {}, second_group = {};

  std::vector<double> differences() const;  ///< second minus first, of pairs
};

/// Difference of the means, second minus first: Welch's interval or, for pairs, Student's interval of the
/// differences; for groups with the standard errors of GroupedMoments.
Difference difference_of_means(const TwoSamples& samples, double confidence);

/// Difference of the medians or, for pairs, median of the differences, with intervals from median_interval:
/// exact for pairs; combined by Zou and Donner (2008, Stat. Med. 27, 1693) for two lists.
Difference difference_of_medians(const TwoSamples& samples, double confidence);

/// Difference of the medians of values that are partly known by a bound only, not as pairs: as above, from
/// censored_quantile and censored_median_interval. Ends are infinite where those are unknown; NaN if a median
/// is.
Difference difference_of_medians(const CensoredValues& first, const CensoredValues& second,
                                 double confidence);

/// Difference of the shares of values equal to 1, all being 0 or 1: Newcombe's intervals from Wilson's, for
/// independent (Newcombe 1998, Stat. Med. 17, 873, method 10) and for paired shares (Newcombe 1998, Stat.
/// Med. 17, 2635, method 10).
Difference difference_of_shares(const TwoSamples& samples, double confidence);

/// Two-sided p-value of the difference of the means, studentized (Welch's statistic or, for pairs, Student's
/// of the differences), under random assignment of the labels "first" and "second": over all assignments, or
/// over 9999 random ones if there are more than 20,000. Groups are assigned as wholes. Valid for samples of
/// any size. 1 if there is nothing to compare.
double permutation_probability(const TwoSamples& samples);

/// The smallest value that permutation_probability can have for as many values.
double least_probability(const TwoSamples& samples);

/// Two groups of crack paths, each given by its positions at the sections; NaN if the crack did not arrive.
struct TwoGroupsOfPaths {
  std::vector<std::vector<double>> first, second;
  bool are_paired = false;
  std::vector<std::size_t> first_group = {}, second_group = {};  ///< as in TwoSamples
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

/// Several tests of the same samples at once.
struct JointTest {
  std::vector<double> adjusted;  ///< p of the looks, then of the paths; NaN if not counted
  /// The earlier look with the same values up to a linear function, with which it is counted as one; or -1.
  std::vector<int> same_as;
  int n_looks = 0;              ///< counted
  int n_too_small = 0;          ///< not counted, as they have too few values for any p of 0.05
  double least = not_a_number;  ///< smallest p-value that any of them could have
};

/// p-values adjusted for all comparisons by Westfall and Young's step-down max-T (1993, Resampling-Based
/// Multiple Testing): by the same permutations for all, so that dependent comparisons count less often. The
/// chance of any false value below 0.05 is at most 5 %.
JointTest joint_test(std::span<const TwoSamples> looks, std::span<const TwoGroupsOfPaths> paths);

/// Comparison of one number or share.
struct ComparedResult {
  ResultInfo info{};
  std::string share_of;  ///< category, such as "two cracks" or "any", whose share is compared; empty for the
                         ///< number itself
  int n_first = 0, n_second = 0;
  double mean_first = not_a_number, mean_second = not_a_number;  ///< or shares
  /// Values that are bounds, of samples that did not break. With any, medians are compared, not means, and p
  /// is of censored_scores.
  int n_bounds_first = 0, n_bounds_second = 0;
  Observation median_first = {}, median_second = {};  ///< of these results only
  Difference of_means = {};
  Difference of_medians = {};  ///< not for shares
  double probability = 1, adjusted = 1;
  double least = not_a_number;  ///< smallest p-value that so many samples can have
  std::string same_as = {};     ///< label of the result with the same values but for a linear function
};

/// Comparison of the paths of the leading cracks, by class (LeaderFrame).
struct ComparedPaths {
  int leading_start = 0;
  int n_first = 0, n_second = 0;
  EnergyDistance distance;
  double adjusted = 1;
  std::vector<Difference> of_means;  ///< at each section [m]
};

/// Samples of one ensemble, by how they ended.
struct SampleCounts {
  int done = 0;
  int undecided = 0;  ///< of those done: still breaking when they ended
  int unbroken = 0;   ///< of those done: nothing broke
  int failed = 0;
  int pending = 0;
};

struct Comparison {
  bool are_paired = false;
  std::string note;                  ///< why samples are not paired or paths not compared; may be empty
  std::vector<std::string> remarks;  ///< what the numbers cover and what they leave out, as sentences
  bool has_shared_base = false;      ///< of either ensemble
  SampleCounts first, second;
  int n_looks = 0;              ///< p-values that are adjusted for each other
  double least = not_a_number;  ///< smallest p-value that any of them could have
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
