// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/running_statistics.h"

#include "crackle/analysis/stop_rule.h"

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>

namespace crackle::analysis {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// Adds a * b without rounding: what the product loses is the remainder of a fused multiplication.
void add_product(parallel::ExactSum& sum, double a, double b) {
  const double product = a * b;
  sum.add(product);
  sum.add(std::fma(a, b, -product));
}

/// What a rounded sum lacks.
double remainder(parallel::ExactSum sum, double rounded) {
  sum.add(-rounded);
  return sum.value();
}

/// Half width of the confidence interval of a mean whose standard deviation was estimated from n values.
double student_half_width(double standard_deviation, int n, double confidence) {
  const boost::math::students_t distribution(n - 1);
  return boost::math::quantile(distribution, (1 + confidence) / 2) * standard_deviation / std::sqrt(n);
}

/// Half width of Wilson's score interval of a share seen in n trials.
double wilson_half_width(double share, int n, double confidence) {
  const double z = boost::math::quantile(boost::math::normal(), (1 + confidence) / 2);
  return z * std::sqrt(share * (1 - share) / n + z * z / (4.0 * n * n)) / (1 + z * z / n);
}

void check_row(const SampleSummary& row, std::size_t sample, std::size_t n_positions) {
  if (row.position.size() != n_positions) {
    throw std::invalid_argument(
        fmt::format("sample {}: {} crack positions instead of {}", sample, row.position.size(), n_positions));
  }
  if (row.pattern < 0 || row.pattern >= n_patterns) {
    throw std::invalid_argument(
        fmt::format("sample {}: pattern {} is not one of 0 to {}", sample, row.pattern, n_patterns - 1));
  }
}

Statistics empty_statistics(std::size_t n_samples, int n_notches, int n_sections, double confidence,
                            std::size_t n_looks) {
  if (!(confidence > 0 && confidence < 1)) {
    throw std::invalid_argument(fmt::format("confidence {}: must lie between 0 and 1", confidence));
  }
  Statistics statistics;
  statistics.n_notches = n_notches;
  statistics.n_sections = n_sections;
  statistics.n_samples = static_cast<int>(n_samples);
  statistics.n_needed = statistics.n_samples;
  statistics.n_looks = static_cast<int>(n_looks);
  statistics.confidence = confidence;
  return statistics;
}

/// The statistics of the leading rows, which are all the ensemble has; `shape` gives shape and confidence.
Statistics compute(const Statistics& shape, std::span<const SampleSummary> rows) {
  Statistics statistics = shape;
  const std::size_t n_positions =
      static_cast<std::size_t>(shape.n_notches) * static_cast<std::size_t>(shape.n_sections);
  statistics.n_done = 0;
  statistics.z_mean.assign(n_positions, none);
  statistics.z_std.assign(n_positions, none);
  statistics.z_half_width.assign(n_positions, none);
  statistics.reached.assign(n_positions, 0);
  statistics.running_mean.assign(static_cast<std::size_t>(shape.n_samples) * n_positions, none);

  std::array<int, n_patterns> pattern_count{};
  std::vector<Moments> moments(n_positions);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool is_done = rows[i].status == SampleStatus::done;
    if (is_done) {
      ++statistics.n_done;
      ++pattern_count[static_cast<std::size_t>(rows[i].pattern)];
    }
    for (std::size_t p = 0; p < n_positions; ++p) {
      const bool arrived = is_done && !std::isnan(rows[i].position[p]);
      if (arrived) moments[p].add(rows[i].position[p]);
      double& mean = statistics.running_mean[i * n_positions + p];
      mean = arrived ? moments[p].mean() : i > 0 ? statistics.running_mean[(i - 1) * n_positions + p] : none;
    }
  }
  // Samples that are not needed repeat the last mean.
  for (std::size_t k = rows.size() * n_positions; k > 0 && k < statistics.running_mean.size(); ++k) {
    statistics.running_mean[k] = statistics.running_mean[k - n_positions];
  }

  const double confidence = 1 - (1 - shape.confidence) / shape.n_looks;
  statistics.z_quantile.clear();
  for (std::size_t p = 0; p < n_positions; ++p) {
    std::vector<double> values;
    for (const SampleSummary& row : rows) {
      if (row.status == SampleStatus::done) values.push_back(row.position[p]);
    }
    for (const double share : quantile_shares) statistics.z_quantile.push_back(quantile(values, share));
    statistics.reached[p] = moments[p].count();
    statistics.z_mean[p] = moments[p].mean();
    statistics.z_std[p] = moments[p].standard_deviation();
    if (moments[p].count() > 1) {
      statistics.z_half_width[p] = student_half_width(statistics.z_std[p], moments[p].count(), confidence);
    }
  }
  for (std::size_t k = 0; k < pattern_count.size(); ++k) {
    const int n = statistics.n_done;
    statistics.pattern_share[k] = n > 0 ? static_cast<double>(pattern_count[k]) / n : none;
    statistics.pattern_half_width[k] =
        n > 0 ? wilson_half_width(statistics.pattern_share[k], n, shape.confidence) : none;
  }
  return statistics;
}

}  // namespace

void Moments::add(double value) {
  first_.add(value);
  add_product(second_, value, value);
  ++n_;
}

double Moments::mean() const {
  return n_ > 0 ? first_.value() / n_ : none;
}

double Moments::standard_deviation() const {
  if (n_ < 2) return none;
  // n (sum of squares) - (sum)^2 without cancellation: every sum is its rounded value and a remainder.
  const double first = first_.value();
  const double second = second_.value();
  parallel::ExactSum difference;
  add_product(difference, n_, second);
  add_product(difference, n_, remainder(second_, second));
  add_product(difference, -first, first);
  add_product(difference, -2 * first, remainder(first_, first));
  return std::sqrt(std::max(0.0, difference.value()) / n_ / (n_ - 1));
}

RunningStatistics::RunningStatistics(std::size_t n_samples, int n_notches, int n_sections, double confidence)
    : statistics_(empty_statistics(n_samples, n_notches, n_sections, confidence, 1)),
      rows_(n_samples, empty_summary(n_notches, n_sections, SampleStatus::pending)),
      moments_(static_cast<std::size_t>(n_notches) * static_cast<std::size_t>(n_sections)) {}

RunningStatistics::RunningStatistics(const input::Parameters& parameters)
    : RunningStatistics(
          static_cast<std::size_t>(parameters.ensemble.samples),
          static_cast<int>(parameters.specimen.notches.size()), static_cast<int>(parameters.sections.size()),
          parameters.ensemble.stop ? parameters.ensemble.stop->confidence : default_confidence) {
  stop_ = parameters.ensemble.stop;
  if (!stop_) return;
  looks_ = look_schedule(parameters.ensemble.samples, stop_->min_samples);
  statistics_.n_looks = static_cast<int>(looks_.size());
}

void RunningStatistics::add(std::size_t sample, SampleSummary row) {
  if (sample >= rows_.size()) {
    throw std::invalid_argument(fmt::format("sample {}: the ensemble has {}", sample, rows_.size()));
  }
  if (row.status == SampleStatus::pending) return;
  if (rows_[sample].status != SampleStatus::pending) {
    throw std::invalid_argument(fmt::format("sample {} is in the statistics already", sample));
  }
  if (row.status == SampleStatus::done) {
    check_row(row, sample, moments_.size());
    for (std::size_t p = 0; p < moments_.size(); ++p) {
      if (!std::isnan(row.position[p])) moments_[p].add(row.position[p]);
    }
    ++statistics_.n_done;
  }
  rows_[sample] = std::move(row);
  while (n_leading_ < rows_.size() && rows_[n_leading_].status != SampleStatus::pending) ++n_leading_;
  look();
}

void RunningStatistics::look() {
  if (!stop_ || stopped_at_) return;
  // At the last look all samples are there: nothing is left to stop.
  for (; next_look_ + 1 < looks_.size() && looks_[next_look_] <= n_leading_; ++next_look_) {
    const std::size_t n = looks_[next_look_];
    if (is_known(compute(statistics_, std::span(rows_).first(n)), stop_->half_width)) {
      stopped_at_ = n;
      return;
    }
  }
}

double RunningStatistics::mean_position(int notch, int section) const {
  if (notch >= statistics_.n_notches || section >= statistics_.n_sections) return none;
  const auto position = static_cast<std::size_t>(notch * statistics_.n_sections + section);
  return stopped_at_ ? statistics().z_mean[position] : moments_[position].mean();
}

double RunningStatistics::median_onset_force() const {
  std::vector<double> forces;
  for (const SampleSummary& row : std::span(rows_).first(stopped_at_.value_or(rows_.size()))) {
    if (row.status == SampleStatus::done) forces.push_back(row.onset_force);
  }
  return quantile(std::move(forces), 0.5);
}

void RunningStatistics::stop_at(std::size_t n) {
  if (n > rows_.size())
    throw std::invalid_argument(fmt::format("stop at sample {}: the ensemble has {}", n, rows_.size()));
  stopped_at_ = n;
}

Statistics RunningStatistics::statistics() const {
  Statistics shape = statistics_;
  if (stopped_at_) shape.n_needed = static_cast<int>(*stopped_at_);
  return compute(shape, std::span(rows_).first(static_cast<std::size_t>(shape.n_needed)));
}

}  // namespace crackle::analysis
