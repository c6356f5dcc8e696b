// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/result_list.h"
#include "analysis/sample_summary.h"
#include "input/parameters.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace crackle::analysis {

class LeaderFrame;

inline constexpr int n_patterns = 4;
inline constexpr double default_confidence = 0.95;
/// Shares of the quantiles: minimum, quartiles and median, maximum.
inline constexpr std::array<double, 5> quantile_shares{0, 0.25, 0.5, 0.75, 1};

/// The scope of an ensemble's confidence intervals, as sentences for the user.
/// @param replicates samples with the same draw of the random inputs
std::string interval_scope(input::Base base, int replicates = 1);

/// Statistics of crack positions (z at sections y = const, y at z = const), rows x sections, row-major. Only
/// samples whose crack arrived count; sections that no sample reached have NaN.
struct PathStatistics {
  std::vector<double> z_mean;  ///< [m]
  std::vector<double> z_std;   ///< sample standard deviation (n - 1) [m]; NaN for fewer than two
  /// Half width of the confidence interval of the mean (Student's t; by whole draws) [m]; likewise. Each of
  /// several looks has the confidence 1 - (1 - confidence) / n_looks, so that together they have that of the
  /// ensemble.
  std::vector<double> z_half_width;
  std::vector<double> z_quantile;     ///< rows x sections x quantile_shares [m]
  std::vector<std::int32_t> reached;  ///< number of samples whose crack arrived
  std::vector<double> running_mean;   ///< n_samples x rows x sections: mean over samples 0..i [m]
  // The following members are not stored in the ensemble file.
  /// Like running_mean: z_half_width over samples 0..i [m]; NaN unless computed by with_running_half_widths.
  std::vector<double> running_half_width;
  std::vector<double> spread_mean;  ///< mean over the samples of SampleSummary::z_spread [m]
  /// 1 where cracks of the row take paths that are apart, so that the mean of all is no crack's position;
  /// empty for a PathGroup.
  std::vector<std::uint8_t> is_divided;
};

/// Samples of one row of RankStatistics whose cracks take one of several paths (path_groups.h), with the
/// statistics of their positions at each section. Not stored in the ensemble file.
struct PathGroup : PathStatistics {
  std::size_t row = 0;
  int n = 0;     ///< its samples
  int n_of = 0;  ///< samples of the row with a position
  double share = not_a_number;
  double share_lower = not_a_number, share_upper = not_a_number;  ///< confidence interval, by whole draws
};

struct Interval {
  double lower, upper;
};

/// Mean and scatter of a result over samples.
struct MeanEstimate {
  double mean = not_a_number;        ///< NaN without samples
  double std = not_a_number;         ///< of the samples; NaN for fewer than two
  double half_width = not_a_number;  ///< of the confidence interval of the mean, by whole draws; likewise
};

/// The fragments of the samples that are done.
struct FragmentStatistics {
  int n_of = 0;                       ///< samples whose fragments are known
  int n_fragmented = 0;               ///< of them, see is_fragmented
  std::vector<MeanEstimate> results;  ///< in the order of for_each_fragment_result [SI]
  std::vector<MeanEstimate> heavier;  ///< of FragmentSummary::heavier; empty without samples
};

/// The traces of some cracks in a plane of [[sections.plane]].
struct TraceStatistics {
  using Estimate = MeanEstimate;                  ///< over the samples whose cracks cross the plane
  int n_crossed = 0;                              ///< samples whose cracks cross the plane
  int n_of = 0;                                   ///< samples whose traces are known
  double share = not_a_number;                    ///< of the former among the latter
  Interval interval{not_a_number, not_a_number};  ///< of the share, by whole draws
  std::vector<MeanEstimate> results;              ///< in the order of for_each_trace_result [SI]
};

/// Positions of the leading or the following cracks, in the frame of the leading crack (LeaderFrame): each
/// row is one start of the frame, for one class of leading starts.
struct RankStatistics : PathStatistics {
  std::vector<std::int32_t> leading_start;  ///< per row: the reference start of the class
  std::vector<std::int32_t> start;          ///< per row: the crack's start
  /// rows x sections: completed samples that would count if their crack arrived; fewer than the whole class
  /// if transformed samples have no such section
  std::vector<std::int32_t> counted;
  std::vector<PathGroup> groups;  ///< none for rows whose samples take one path
};

/// Statistics over all completed samples, bitwise independent of the order in which they were added. For an
/// ensemble that stopped early (see stop_rule.h), over the samples it needed. Its own positions are those of
/// each start's cracks, leading or following: rows are starts.
struct Statistics : PathStatistics {
  int n_starts = 0;
  int n_sections = 0;
  int n_samples = 0;  ///< rows of running_mean: all samples of the ensemble
  int n_done = 0;
  int n_needed =
      0;            ///< samples 0 to n_needed - 1 form the ensemble; fewer than n_samples if it stopped early
  int n_looks = 1;  ///< number of looks at which it could stop
  double confidence = default_confidence;  ///< of the intervals below
  input::Base base = input::Base::shared;  ///< of the samples; determines what the intervals cover
  int replicates = 1;  ///< samples i to i + replicates - 1 have one draw; intervals are by whole draws
  std::array<double, n_patterns> pattern_share{};       ///< NaN when no sample is done
  std::array<double, n_patterns> pattern_half_width{};  ///< Wilson interval's half width; likewise
  std::array<double, n_patterns> pattern_lower{};       ///< its ends: it is not centred on the share
  std::array<double, n_patterns> pattern_upper{};
  std::vector<std::int32_t> reference_start;  ///< for each start, see LeaderFrame
  std::vector<std::string> start_names;       ///< likewise
  std::vector<std::string> crack_parts;       ///< see analysis::crack_parts
  bool has_strength_scatter = false;  ///< by the input, or as the body has no crack starts: loads show it
  RankStatistics leader;              ///< a row for each class
  RankStatistics leader_one_crack;    ///< the same over samples with Pattern::one_crack
  RankStatistics leader_two_cracks;   ///< and Pattern::two_cracks
  RankStatistics follower;            ///< for each class, a row for each other start
  std::size_t n_planes = 0;
  std::vector<TraceStatistics> traces;  ///< n_planes x cracks::n_trace_rows
  FragmentStatistics fragments;
};

/// Calls visit(name, ranked statistics) for the members of type RankStatistics; the names are those of the
/// groups in /statistics of the ensemble's file.
template <class Statistics, class Visit>
void for_each_rank(Statistics& statistics, Visit&& visit) {
  visit("leader", statistics.leader);
  visit("leader/one_crack", statistics.leader_one_crack);
  visit("leader/two_cracks", statistics.leader_two_cracks);
  visit("follower", statistics.follower);
}

/// For a body without symmetry.
/// @param samples one row for each sample of the ensemble, in the order of their numbers
/// @throws std::invalid_argument when a row has the wrong shape or `confidence` is not between 0 and 1
Statistics make_statistics(std::span<const SampleSummary> samples, int n_starts, int n_sections,
                           double confidence = default_confidence);

/// As above, for the body and sections of the input, with its [ensemble.stop] (without it default_confidence
/// and all samples): the statistics in ensemble.h5.
/// @param n_needed if the ensemble is known to need the samples 0 to n_needed - 1
Statistics make_statistics(std::span<const SampleSummary> samples, const input::Study& study,
                           std::optional<int> n_needed = {});

/// The same statistics with running_half_width, which takes longest to compute.
/// @param frame with the sections of the statistics
Statistics with_running_half_widths(const Statistics& statistics, std::span<const SampleSummary> samples,
                                    const LeaderFrame& frame);

/// Marks the rows of samples that the ensemble did not need as pending.
/// @param first number of the sample in rows[0]
void leave_out_surplus(const Statistics& statistics, std::size_t first, std::vector<SampleSummary>& rows);

/// Wilson's score interval of a share.
struct WilsonInterval {
  double centre;
  double half_width;
};

/// Interval for a share observed in n trials, or as if in so many.
WilsonInterval wilson_interval(double share, double n, double confidence);

/// The wilson_interval of n_hits in n > 0 trials, clipped to [0, 1].
Interval share_interval(int n_hits, int n, double confidence);

/// Student's t for which P(|T| < t) = confidence, for the mean of n values; NaN for fewer than two.
double student_quantile(int n, double confidence);

/// Half width of the confidence interval of a mean whose standard deviation is estimated from n values
/// (Student's t); NaN for fewer than two.
double student_half_width(double standard_deviation, int n, double confidence);

/// Confidence of the interval at each of several looks, such that together they have the given confidence
/// (Bonferroni).
inline double confidence_of_look(double confidence, int n_looks) {
  return 1 - (1 - confidence) / n_looks;
}

/// The quantile of the values, linear between order statistics (Hyndman and Fan's type 7). NaN values are
/// ignored; NaN if none is left.
double quantile(std::vector<double> values, double share);

/// Origin of the rows of statistics.
struct Origin {
  std::vector<std::string> notes;    ///< remarks, as sentences
  std::vector<std::string> lacking;  ///< names of the results missing from files of an older format
};

/// True if the files lack a result.
inline bool lacks(const Origin& origin, const std::string& result) {
  return std::ranges::find(origin.lacking, result) != origin.lacking.end();
}

/// Table entries of a result over the completed samples that have it, in SI units.
struct ResultStatistics {
  ResultInfo info{};
  int n_values = 0;  ///< 0: the other members are undefined
  int n_bounds = 0;  ///< of the values: unbroken samples, of which only a lower bound is known
  // By the result's Reduction:
  std::array<Observation, quantile_shares.size()> quantiles{};  ///< censored_quantile
  std::vector<int> counts;                                      ///< of each category
  double mean = 0;
  std::array<Observation, 2> of_median{};  ///< censored_median_interval
  int n_any = 0;                           ///< number of samples with a value above 0
  Interval share_any{};                    ///< confidence interval of the share of these samples
};

/// For all results except those missing from the files, in table order.
std::vector<ResultStatistics> result_statistics(std::span<const SampleSummary> samples, double confidence,
                                                const Origin& origin, int replicates = 1);

/// In which tables show positions.
ShownUnit unit_of_positions(const PathStatistics& paths);

/// The statistics as readable tables: crack positions, patterns, onset, failed samples.
std::string to_text(const Statistics& statistics, std::span<const SampleSummary> samples,
                    const input::Sections& sections, const Origin& origin = {});

/// The statistics and their rows as a JSON document; jobs/results.md lists its members.
/// @param parameters with the sections of the statistics
std::string to_json(const Statistics& statistics, std::span<const SampleSummary> samples,
                    const input::Parameters& parameters, const Origin& origin,
                    bool with_sensitivities = true);

}  // namespace crackle::analysis
