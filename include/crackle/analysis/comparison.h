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
  double lower = not_a_number;  ///< NaN where there are too few values
  double upper = not_a_number;
};

/// Two lists of values; where they are paired, value i of one belongs to value i of the other.
struct TwoSamples {
  std::vector<double> first, second;
  bool are_paired = false;
};

/// Of the means, second less first: Welch's interval, or Student's of the differences of pairs.
Difference difference_of_means(const TwoSamples& samples, double confidence);

/// Of the medians, or the median of the differences of pairs: percentiles of 4000 bootstrap samples, the same
/// in every call.
Difference difference_of_medians(const TwoSamples& samples, double confidence);

/// Of the shares of values that are 1, all being 0 or 1: Newcombe's intervals from Wilson's, for independent
/// (Newcombe 1998, Stat. Med. 17, 873, method 10) and for paired shares (Newcombe 1998, Stat. Med. 17, 2635,
/// method 10).
Difference difference_of_shares(const TwoSamples& samples, double confidence);

/// Two-sided probability of means that differ by so many of their standard errors (Welch's; of pairs, of
/// their differences), were the labels "first" and "second" given at random: over all ways of giving them, or
/// over 9999 random ones where there are more than 20,000. Holds in samples of any size. 1 where there is
/// nothing to tell.
double permutation_probability(const TwoSamples& samples);

/// Two groups of crack paths: of each, the positions at the sections, NaN where a crack did not arrive.
struct TwoGroupsOfPaths {
  std::vector<std::vector<double>> first, second;
  bool are_paired = false;
};
struct EnergyDistance {
  double value = not_a_number;  ///< as the positions
  double probability = 1;       ///< of one as large by chance, by permutations as above
};
/// Between the distributions of the paths (Székely and Rizzo 2004): 2 E|X - Y| - E|X - X'| - E|Y - Y'|, where
/// the distance of two paths is the root mean square over the sections that both reach; two without one are
/// left out. Of pairs, between their differences and the mirror images of these.
EnergyDistance energy_distance(const TwoGroupsOfPaths& paths);

/// Holm's adjustment of the probabilities of several looks: one below 0.05 is by chance in 5 % of such
/// comparisons at most. NaN is no look.
std::vector<double> adjusted_for_looks(std::span<const double> probabilities);

/// What a comparison tells of one number or share.
struct ComparedResult {
  ResultInfo info{};
  std::string share_of;  ///< "two cracks", "any": a share of the samples; empty for the number itself
  int n_first = 0, n_second = 0;
  double mean_first = not_a_number, mean_second = not_a_number;  ///< or shares
  Difference of_means = {};
  Difference of_medians = {};  ///< not of shares
  double probability = 1, adjusted = 1;
};

/// Of the crack that leads, by its class (LeaderFrame).
struct ComparedPaths {
  int leading_notch = 0;
  int n_first = 0, n_second = 0;
  EnergyDistance distance;
  double adjusted = 1;
  std::vector<Difference> of_means;  ///< at each section [m]
};

struct Comparison {
  bool are_paired = false;
  std::string note;  ///< why the samples are not paired, or the paths not compared; may be empty
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

/// The samples that are done of two ensembles: pairs where both have the same bodies, sample by sample, and
/// independent ones otherwise. Probabilities are adjusted for all looks of the comparison.
Comparison compare(const Compared& first, const Compared& second, double confidence = default_confidence);

/// The comparison as tables to read.
/// @param first, second names
std::string to_text(const Comparison& comparison, const std::string& first, const std::string& second,
                    const input::Sections& sections);

/// Of several ensembles with the first of them, as a JSON document; NaN is null.
std::string to_json(std::span<const Comparison> comparisons, std::span<const std::string> names,
                    const input::Sections& sections);

}  // namespace crackle::analysis
