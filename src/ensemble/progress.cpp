// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/progress.h"

#include "common/real.h"
#include "common/text_table.h"
#include "geometry/body.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace crackle::ensemble {

namespace {

constexpr double unknown = not_a_number;

/// The sections that the crack of the first notch can cross, or all if there is none, from the middle one
/// outwards.
std::vector<std::size_t> sections_from_middle(const input::Study& study) {
  const std::vector<input::Section> sections = study.sections.all();
  const auto body = geometry::make_composite_body(study);
  std::vector<std::size_t> crossed;
  for (std::size_t i = 0; i < sections.size() && !body->crack_starts().empty(); ++i) {
    const geometry::CrackStart& first = body->crack_starts().front();
    if (!first.is_straight || first.advance_to(geometry::plane_of(sections[i]))) crossed.push_back(i);
  }
  if (crossed.empty())
    for (std::size_t i = 0; i < sections.size(); ++i) crossed.push_back(i);
  if (crossed.empty()) return crossed;
  const std::size_t middle = crossed[crossed.size() / 2];
  std::ranges::stable_sort(crossed, {}, [&](std::size_t i) { return i < middle ? middle - i : i - middle; });
  return crossed;
}

}  // namespace

Progress::Progress(std::size_t n_to_do, int n_groups, const input::Study& study)
    : n_to_do_(n_to_do),
      n_groups_(n_groups),
      sections_(study.sections.all()),
      watched_(sections_from_middle(study)),
      statistics_(study) {}

void Progress::kept(std::uint64_t sample, const analysis::SampleSummary& summary) {
  statistics_.add(sample, summary);
  ++(summary.status == analysis::SampleStatus::done ? n_done_ : n_failed_);
}

void Progress::started(std::uint64_t sample, double now) {
  running_[sample] = now;
  where_.clear();
}

void Progress::finished(const SampleReport& report, double now) {
  // A sample whose realization failed was never handed out and does not count towards durations.
  if (const auto start = running_.find(report.sample); start != running_.end()) {
    duration_sum_ += now - start->second;
    ++n_durations_;
    running_.erase(start);
  }
  ++n_ended_here_;
  kept(report.sample, report.summary);
}

int Progress::n_left() const {
  if (statistics_.stopped_at()) return 0;
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
  // Bounded below by all groups working without a pause, and by the longest remaining sample.
  return std::max(work / n_groups_, longest);
}

std::string Progress::line(double now) const {
  std::string text =
      fmt::format("{} done, {} failed, {} running, {} pending", n_done_, n_failed_, n_running(), n_left());
  if (const double rest = time_left(now); std::isfinite(rest) && rest > 0) {
    text += fmt::format(", about {} remaining", duration_text(rest));
  }
  if (running_.size() == 1 && !where_.empty())
    text += fmt::format("; sample {}: {}", running_.begin()->first, where_);
  if (const std::string found = means(); !found.empty()) text += "; " + found;
  return text;
}

std::pair<std::size_t, double> Progress::mean_position() const {
  std::vector<analysis::RunningStatistics::LeaderPosition> found;
  for (const std::size_t section : watched_)
    found.push_back(statistics_.leader_position(static_cast<int>(section)));
  std::int64_t most = 0;
  for (const auto& one : found) most = std::max(most, one.n);
  for (std::size_t k = 0; k < found.size(); ++k)
    if (2 * found[k].n >= most && !statistics_.is_divided(found[k])) return {watched_[k], found[k].mean};
  return {0, not_a_number};
}

std::string Progress::means() const {
  std::string text;
  if (const auto [number, mean] = mean_position(); std::isfinite(mean)) {
    const input::Section& section = sections_[number];
    const ShownUnit unit = shown_unit({"mm", 1e3}, "m", std::abs(mean));
    text = fmt::format("mean {} of leading cracks at {}: {:.3f} {}", input::coordinate_of(section),
                       input::name_of(section), mean * unit.factor, unit.name);
  }
  const auto [name, median, n_unbroken] = statistics_.median_load();
  // Started from rest, samples have no onset, and little is said by the load when they first broke.
  if (name == "first_break_load" || std::isnan(median.value)) return text;
  const ShownUnit unit = shown_unit({"N", 1}, "N", std::abs(median.value));
  text += fmt::format("{}median {} {}{:.3f} {}", text.empty() ? "" : ", ",
                      name == "peak_load" ? "peak load" : "onset", median.is_bound ? "above " : "",
                      median.value * unit.factor, unit.name);
  if (n_unbroken > 0) text += fmt::format(" ({} of {} unbroken)", n_unbroken, statistics_.n_done());
  return text;
}

std::string format_samples(std::span<const std::uint64_t> samples) {
  std::string text = samples.size() == 1 ? "sample" : "samples";
  for (std::size_t first = 0, last = 0; first < samples.size(); first = last + 1) {
    for (last = first; last + 1 < samples.size() && samples[last + 1] == samples[last] + 1;) ++last;
    text += fmt::format("{} {}", first == 0 ? "" : ",", samples[first]);
    if (last > first) text += fmt::format("-{}", samples[last]);
  }
  return text;
}

}  // namespace crackle::ensemble
