// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/leader_frame.h"
#include "analysis/statistics.h"
#include "parallel/exact_sum.h"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace crackle::analysis {

/// Mean and standard deviation of a sequence of values. The sums are exact, so the results are bitwise
/// independent of the order.
class Moments {
public:
  /// @throws std::domain_error for a value that is not finite
  void add(double value);
  int count() const { return n_; }
  double mean() const;                ///< NaN without values
  double standard_deviation() const;  ///< of the sample (n - 1); NaN for fewer than two values

private:
  int n_ = 0;
  parallel::ExactSum first_;   ///< of the values
  parallel::ExactSum second_;  ///< of their squares
};

/// Statistics of an ensemble in progress: rows are added as samples end, in any order; at any time the result
/// is bitwise that of make_statistics over the rows so far. With [ensemble.stop] it also decides when the
/// ensemble has enough samples.
class RunningStatistics {
public:
  /// @throws std::runtime_error when the specimen is not a valid body
  explicit RunningStatistics(const input::Study& study);
  /// Without a stopping rule, for a body without symmetry.
  RunningStatistics(std::size_t n_samples, int n_starts, int n_sections, double confidence);

  /// Adds the row of a sample; a pending one changes nothing.
  /// @throws std::invalid_argument when the sample is outside the ensemble or already added, or when the row
  ///   of a completed sample has the wrong shape
  void add(std::size_t sample, SampleSummary row);

  int n_done() const { return statistics_.n_done; }
  /// Where the leading cracks of the class (see LeaderFrame) with most arrivals at a section cross it.
  struct LeaderPosition {
    double mean = not_a_number;  ///< [m]; NaN if none arrived yet
    std::int64_t n = 0;          ///< arrivals
    std::size_t position = 0;    ///< index in Statistics::leader
  };
  LeaderPosition leader_position(int section) const;
  /// True if these cracks take several paths there, so that the mean is no crack's position. Takes longer.
  bool is_divided(const LeaderPosition& leaders) const;
  /// Median of the headline_load of the samples so far; NaN while none has one.
  struct MedianLoad {
    std::string name;  ///< of the result
    Observation median;
    int n_unbroken = 0;
  };
  MedianLoad median_load() const;

  /// The smallest number n for which the samples 0 to n - 1 are enough, see StopRule; empty while undecided.
  /// Never changed by rows added later.
  std::optional<std::size_t> stopped_at() const { return stopped_at_; }

  /// Declares the samples 0 to n - 1 enough, overriding the rule, if the decision was made elsewhere.
  /// @throws std::invalid_argument when the ensemble has fewer
  void stop_at(std::size_t n);

  const std::vector<SampleSummary>& rows() const { return rows_; }

  /// Over the rows so far; over the first n once stopped_at() is n.
  Statistics statistics() const;

private:
  RunningStatistics(std::size_t n_samples, LeaderFrame frame, double confidence);
  void look();
  std::span<const SampleSummary> needed_rows() const {
    return std::span(rows_).first(stopped_at_.value_or(rows_.size()));
  }

  LeaderFrame frame_;
  Statistics statistics_;  ///< shape and counts
  std::vector<SampleSummary> rows_;
  std::vector<Moments> leader_moments_;  ///< as in Statistics::leader
  std::optional<input::EnsembleStop> stop_;
  std::vector<std::size_t> looks_;
  std::size_t n_ended_ = 0;    ///< samples 0 to n_ended_ - 1 have ended
  std::size_t next_look_ = 0;  ///< index into looks_
  std::optional<std::size_t> stopped_at_;
};

}  // namespace crackle::analysis
