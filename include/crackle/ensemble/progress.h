// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"
#include "crackle/ensemble/sample_report.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace crackle::ensemble {

/// Where an ensemble stands: counts, the time left, and the mean over the samples done so far. Times are
/// seconds on any clock of the caller. The mean is for people to look at; what is stored is computed from the
/// sample files at the end.
class Progress {
public:
  /// @param n_to_do samples of this run
  /// @param section_y sections [m]; the middle one's mean crack position of notch 0 is shown
  Progress(std::size_t n_to_do, int n_groups, int n_notches, std::vector<double> section_y);

  /// A sample that an earlier run has ended.
  void kept(const analysis::SampleSummary& summary);
  void started(std::uint64_t sample, double now);
  void finished(const SampleReport& report, double now);

  int n_done() const { return n_done_; }
  int n_failed() const { return n_failed_; }
  int n_running() const { return static_cast<int>(running_.size()); }
  int n_left() const;  ///< neither ended nor running

  /// Seconds until the last sample ends, from the mean duration and the groups; NaN before the first one has.
  double time_left(double now) const;
  double mean_position() const;     ///< crack of notch 0 at the middle section [m]; NaN when none arrived
  double mean_onset_force() const;  ///< [N]; NaN when no sample broke

  /// One line: done, failed, running, left, time left, means.
  std::string line(double now) const;

private:
  void count(const analysis::SampleSummary& summary);

  std::size_t n_to_do_;
  int n_groups_;
  int n_notches_;
  std::vector<double> section_y_;
  std::map<std::uint64_t, double> running_;  ///< sample, time of its start
  int n_done_ = 0, n_failed_ = 0;
  std::size_t n_ended_here_ = 0;  ///< in this run
  double duration_sum_ = 0;
  int n_durations_ = 0;
  double position_sum_ = 0, force_sum_ = 0;
  int n_positions_ = 0, n_forces_ = 0;
};

/// "45 s", "12 min 30 s", "3 h 20 min", "2 d 3 h".
std::string format_duration(double seconds);

}  // namespace crackle::ensemble
