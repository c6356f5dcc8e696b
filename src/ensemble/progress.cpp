// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace crackle::ensemble {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

}  // namespace

Progress::Progress(std::size_t n_to_do, int n_groups, int n_notches, std::vector<double> section_y)
    : n_to_do_(n_to_do), n_groups_(n_groups), n_notches_(n_notches), section_y_(std::move(section_y)) {}

void Progress::count(const analysis::SampleSummary& summary) {
  if (summary.status != analysis::SampleStatus::done) {
    ++n_failed_;
    return;
  }
  ++n_done_;
  if (std::isfinite(summary.onset_force)) {
    force_sum_ += summary.onset_force;
    ++n_forces_;
  }
  const std::size_t middle = section_y_.size() / 2;
  if (n_notches_ > 0 && middle < summary.z.size() && std::isfinite(summary.z[middle])) {
    position_sum_ += summary.z[middle];
    ++n_positions_;
  }
}

void Progress::kept(const analysis::SampleSummary& summary) {
  count(summary);
}

void Progress::started(std::uint64_t sample, double now) {
  running_[sample] = now;
}

void Progress::finished(const SampleReport& report, double now) {
  // A sample whose realization could not be made was never handed out, and tells nothing about durations.
  if (const auto start = running_.find(report.sample); start != running_.end()) {
    duration_sum_ += now - start->second;
    ++n_durations_;
    running_.erase(start);
  }
  ++n_ended_here_;
  count(report.summary);
}

int Progress::n_left() const {
  return static_cast<int>(n_to_do_ - n_ended_here_ - running_.size());
}

double Progress::time_left(double now) const {
  if (n_left() == 0 && running_.empty()) return 0;
  if (n_durations_ == 0) return unknown;
  const double mean = duration_sum_ / n_durations_;
  double work = mean * n_left();
  double longest = n_left() > 0 ? mean : 0;
  for (const auto& [sample, start] : running_) {
    const double rest = std::max(mean - (now - start), 0.0);
    work += rest;
    longest = std::max(longest, rest);
  }
  // Neither can the groups be faster than all at work without a pause, nor can the end come before the sample
  // that takes longest.
  return std::max(work / n_groups_, longest);
}

double Progress::mean_position() const {
  return n_positions_ > 0 ? position_sum_ / n_positions_ : unknown;
}

double Progress::mean_onset_force() const {
  return n_forces_ > 0 ? force_sum_ / n_forces_ : unknown;
}

std::string Progress::line(double now) const {
  std::string text =
      fmt::format("{} done, {} failed, {} running, {} left", n_done_, n_failed_, n_running(), n_left());
  if (const double rest = time_left(now); std::isfinite(rest) && rest > 0) {
    text += fmt::format(", {} to go", format_duration(rest));
  }
  std::string means;
  if (n_positions_ > 0) {
    means =
        fmt::format("z({:g} mm) = {:.2f} mm", section_y_[section_y_.size() / 2] * 1e3, mean_position() * 1e3);
  }
  if (n_forces_ > 0) {
    means += fmt::format("{}onset {:.1f} N", means.empty() ? "" : ", ", mean_onset_force());
  }
  if (!means.empty()) text += "; mean " + means;
  return text;
}

std::string format_duration(double seconds) {
  const auto total = std::llround(std::max(seconds, 0.0));
  const auto days = total / 86400, hours = total / 3600 % 24, minutes = total / 60 % 60;
  if (days > 0) return fmt::format("{} d {} h", days, hours);
  if (hours > 0) return fmt::format("{} h {} min", hours, minutes);
  if (minutes > 0) return fmt::format("{} min {} s", minutes, total % 60);
  return fmt::format("{} s", total);
}

}  // namespace crackle::ensemble
