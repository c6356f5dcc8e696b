// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_results.h"
#include "crackle/analysis/sample_summary.h"
#include "crackle/input/parameters.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace crackle::analysis {

inline constexpr int n_patterns = 4;
inline constexpr double default_confidence = 0.95;
/// Shares of the quantiles: least value, quartiles and median, greatest value.
inline constexpr std::array<double, 5> quantile_shares{0, 0.25, 0.5, 0.75, 1};

/// What the confidence intervals of an ensemble leave out, for people.
constexpr const char* interval_scope(input::Base base) {
  return base == input::Base::shared ? "Intervals cover the scatter of samples that share one set of mother "
                                       "points; that between such "
                                       "sets is not in them."
                                     : "Intervals cover the scatter of independent samples, each with a set "
                                       "of mother points of its own.";
}

/// Statistics of crack positions (z at sections y = const, y at z = const), rows x sections, row-major. They
/// count the samples whose crack arrived; a section that no sample reached has NaN.
struct PathStatistics {
  std::vector<double> z_mean;  ///< [m]
  std::vector<double> z_std;   ///< sample standard deviation (n - 1) [m]; NaN for fewer than two
  /// Of the confidence interval of the mean, Student's t [m]; likewise. Each of several looks has the
  /// confidence 1 - (1 - confidence) / n_looks, so that all of them together have the one of the ensemble.
  std::vector<double> z_half_width;
  std::vector<double> z_quantile;     ///< rows x sections x quantile_shares [m]
  std::vector<std::int32_t> reached;  ///< number of samples whose crack arrived
  std::vector<double> running_mean;   ///< n_samples x rows x sections: mean over samples 0..i [m]
  // What follows is not in the ensemble's file.
  /// Like running_mean: z_half_width over samples 0..i [m]; NaN but from with_running_half_widths.
  std::vector<double> running_half_width;
  std::vector<double> spread_mean;  ///< mean over the samples of SampleSummary::z_spread [m]
};

/// Positions of cracks of one rank, in the frame of the leading crack (LeaderFrame): each row is one notch of
/// the frame, for one class of leading notches.
struct RankStatistics : PathStatistics {
  std::vector<std::int32_t> leading_notch;  ///< of each row: the reference notch of the class
  std::vector<std::int32_t> notch;          ///< of each row: where the crack starts
  /// rows x sections: samples done that would count if their crack arrived; fewer than all of the class where
  /// turned samples have no section
  std::vector<std::int32_t> counted;
};

/// Statistics over all samples done; the same bits whatever the order in which they were added. Of an
/// ensemble that stopped early (see stop_rule.h), over the samples it needed. Its own positions are those of
/// each notch's cracks, leading and following ones together: rows are notches.
struct Statistics : PathStatistics {
  int n_notches = 0;
  int n_sections = 0;
  int n_samples = 0;  ///< rows of running_mean: all samples of the ensemble
  int n_done = 0;
  int n_needed =
      0;  ///< samples 0 to n_needed - 1 are the ensemble; fewer than n_samples when it stopped early
  int n_looks = 1;                                      ///< at which it could stop
  double confidence = default_confidence;               ///< of the intervals below
  input::Base base = input::Base::shared;               ///< of the samples: what the intervals cover
  std::array<double, n_patterns> pattern_share{};       ///< NaN when no sample is done
  std::array<double, n_patterns> pattern_half_width{};  ///< Wilson interval's half width; likewise
  std::array<double, n_patterns> pattern_lower{};       ///< its ends: it does not lie round the share
  std::array<double, n_patterns> pattern_upper{};
  std::vector<std::int32_t> reference_notch;  ///< of each notch, see LeaderFrame
  RankStatistics leader;                      ///< a row for each class
  RankStatistics leader_one_crack;            ///< the same over samples with Pattern::one_crack
  RankStatistics leader_two_cracks;           ///< and Pattern::two_cracks
  RankStatistics follower;                    ///< for each class a row for each other notch
};

/// Calls visit(name, leaders or followers) for all that Statistics holds by rank; the names are those of the
/// groups in /statistics of the ensemble's file.
template <class Statistics, class Visit>
void for_each_rank(Statistics& statistics, Visit&& visit) {
  visit("leader", statistics.leader);
  visit("leader/one_crack", statistics.leader_one_crack);
  visit("leader/two_cracks", statistics.leader_two_cracks);
  visit("follower", statistics.follower);
}

/// Of a body without symmetry.
/// @param samples one row for each sample of the ensemble, in the order of their numbers
/// @throws std::invalid_argument when a row has another shape or `confidence` is not between 0 and 1
Statistics make_statistics(std::span<const SampleSummary> samples, int n_notches, int n_sections,
                           double confidence = default_confidence);

/// As above, for the body and sections of the input, with its [ensemble.stop] (default_confidence and all
/// samples without): the statistics of its ensemble.h5.
/// @param n_needed of an ensemble that is known to need the samples 0 to n_needed - 1
Statistics make_statistics(std::span<const SampleSummary> samples, const input::Parameters& parameters,
                           std::optional<int> n_needed = {});

/// The same statistics of the same samples with running_half_width, which takes the longest.
/// @param parameters with the sections of the statistics
Statistics with_running_half_widths(const Statistics& statistics, std::span<const SampleSummary> samples,
                                    const input::Parameters& parameters);

/// Makes the rows of samples that an ensemble did not need pending.
/// @param first number of the sample in rows[0]
void leave_out_surplus(const Statistics& statistics, std::size_t first, std::vector<SampleSummary>& rows);

/// Wilson's score interval of a share.
struct WilsonInterval {
  double centre;
  double half_width;
};

/// Of a share seen in n trials.
WilsonInterval wilson_interval(double share, int n, double confidence);

/// The wilson_interval of n_hits in n > 0 trials, cut off at 0 and 1.
struct Interval {
  double lower, upper;
};
Interval share_interval(int n_hits, int n, double confidence);

/// Half width of the confidence interval of a mean whose standard deviation was estimated from n values
/// (Student's t); NaN for fewer than two.
double student_half_width(double standard_deviation, int n, double confidence);

/// Confidence of the interval at each of several looks, so that all of them hold together.
inline double confidence_of_look(double confidence, int n_looks) {
  return 1 - (1 - confidence) / n_looks;
}

/// The value below which a share of the values lies, linear between neighbours in rank (Hyndman and Fan's
/// type 7). NaN values are left out; NaN when none is left.
double quantile(std::vector<double> values, double share);

/// Where the rows of statistics come from.
struct Origin {
  std::vector<std::string> notes;    ///< sentences about it
  std::vector<std::string> lacking;  ///< names of the results that the files, of an older format, do not hold
};

/// Whether the files do not hold a result.
inline bool lacks(const Origin& origin, const std::string& result) {
  return std::ranges::find(origin.lacking, result) != origin.lacking.end();
}

/// What a table over all samples says of a result: of the samples that are done and have it, in SI units.
struct ResultStatistics {
  ResultInfo info{};
  int n_values = 0;  ///< without any, what follows says nothing
  // By the result's Reduction:
  std::array<double, quantile_shares.size()> quantiles{};
  std::vector<int> counts;  ///< of each category
  double mean = 0;
  int n_any = 0;         ///< samples in which it is above 0
  Interval share_any{};  ///< confidence interval of their share
};

/// Of all results but those that the files lack, in the order of tables.
std::vector<ResultStatistics> result_statistics(std::span<const SampleSummary> samples, double confidence,
                                                const Origin& origin);

/// The statistics as a table to read: crack positions, patterns, onset, samples that failed.
std::string to_text(const Statistics& statistics, std::span<const SampleSummary> samples,
                    const input::Sections& sections, const Origin& origin = {});

/// The statistics and the rows they are over as a JSON document; jobs/results.md lists its members.
/// @param parameters with the sections of the statistics
std::string to_json(const Statistics& statistics, std::span<const SampleSummary> samples,
                    const input::Parameters& parameters, const Origin& origin);

}  // namespace crackle::analysis
