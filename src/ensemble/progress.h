// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/running_statistics.h"
#include "analysis/sample_summary.h"
#include "ensemble/sample_report.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace crackle::ensemble {

/// Progress of an ensemble: counts, time left, and statistics of the samples done so far. Times are seconds
/// on any clock of the caller.
class Progress {
public:
  /// @param n_to_do samples to compute in this run
  Progress(std::size_t n_to_do, int n_groups, const input::Study& study);

  /// A sample that finished in an earlier run.
  void kept(std::uint64_t sample, const analysis::SampleSummary& summary);
  void started(std::uint64_t sample, double now);
  void finished(const SampleReport& report, double now);
  /// A sample under way is left for a later run.
  void suspended(std::uint64_t sample) { running_.erase(sample); }
  /// Status line of the only running sample.
  void at_work(const std::string& where) { where_ = where; }

  int n_done() const { return n_done_; }
  int n_failed() const { return n_failed_; }
  int n_running() const { return static_cast<int>(running_.size()); }
  int n_left() const;  ///< pending: neither finished nor running, and still needed

  /// Seconds until the last sample ends, from the mean duration and the number of groups; NaN until the first
  /// one has ended.
  double time_left(double now) const;
  /// A section and the mean position of the leading cracks there [m], NaN if none arrived, see
  /// RunningStatistics. Of the sections that the crack of notch 0 can cross it is the one nearest to the
  /// middle at which at least half as many cracks arrive as at any other, not one inside a hole, and which
  /// they cross in one group.
  std::pair<std::size_t, double> mean_position() const;
  /// Over the finished samples; decides whether more are needed.
  const analysis::RunningStatistics& statistics() const { return statistics_; }

  /// Mean position and median onset; empty while there are none.
  std::string means() const;
  /// One line: done, failed, running, left, time left, status of a single running sample, mean position and
  /// median onset.
  std::string line(double now) const;

private:
  std::size_t n_to_do_;
  int n_groups_;
  std::vector<input::Section> sections_;
  std::vector<std::size_t> watched_;         ///< sections for the mean position, the preferred ones first
  std::map<std::uint64_t, double> running_;  ///< sample, start time
  std::string where_;                        ///< status of the running sample; may be empty
  int n_done_ = 0, n_failed_ = 0;
  std::size_t n_ended_here_ = 0;  ///< samples ended in this run
  double duration_sum_ = 0;
  int n_durations_ = 0;
  analysis::RunningStatistics statistics_;
};

/// "sample 4", or "samples 3-17, 20". @param samples ascending, at least one
std::string format_samples(std::span<const std::uint64_t> samples);

}  // namespace crackle::ensemble
