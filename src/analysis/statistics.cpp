// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/statistics.h"

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace crackle::analysis {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

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

void check(std::span<const SampleSummary> samples, std::size_t n_positions, double confidence) {
  if (!(confidence > 0 && confidence < 1)) {
    throw std::invalid_argument(fmt::format("confidence {}: must lie between 0 and 1", confidence));
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const SampleSummary& sample = samples[i];
    if (sample.status != SampleStatus::done) continue;
    if (sample.z.size() != n_positions) {
      throw std::invalid_argument(
          fmt::format("sample {}: {} crack positions instead of {}", i, sample.z.size(), n_positions));
    }
    if (sample.pattern < 0 || sample.pattern >= n_patterns) {
      throw std::invalid_argument(
          fmt::format("sample {}: pattern {} is not one of 0 to {}", i, sample.pattern, n_patterns - 1));
    }
  }
}

}  // namespace

Statistics make_statistics(std::span<const SampleSummary> samples, int n_notches, int n_sections,
                           double confidence) {
  const std::size_t n_positions = static_cast<std::size_t>(n_notches) * static_cast<std::size_t>(n_sections);
  check(samples, n_positions, confidence);

  Statistics statistics;
  statistics.n_notches = n_notches;
  statistics.n_sections = n_sections;
  statistics.n_samples = static_cast<int>(samples.size());
  statistics.confidence = confidence;
  statistics.z_mean.assign(n_positions, none);
  statistics.z_std.assign(n_positions, none);
  statistics.z_half_width.assign(n_positions, none);
  statistics.reached.assign(n_positions, 0);
  statistics.running_mean.assign(samples.size() * n_positions, none);

  std::array<int, n_patterns> pattern_count{};
  for (const SampleSummary& sample : samples) {
    if (sample.status != SampleStatus::done) continue;
    ++statistics.n_done;
    ++pattern_count[static_cast<std::size_t>(sample.pattern)];
  }
  for (std::size_t k = 0; k < pattern_count.size(); ++k) {
    const int n = statistics.n_done;
    statistics.pattern_share[k] = n > 0 ? static_cast<double>(pattern_count[k]) / n : none;
    statistics.pattern_half_width[k] =
        n > 0 ? wilson_half_width(statistics.pattern_share[k], n, confidence) : none;
  }

  const auto arrived = [](const SampleSummary& sample, std::size_t p) {
    return sample.status == SampleStatus::done && !std::isnan(sample.z[p]);
  };
  for (std::size_t p = 0; p < n_positions; ++p) {
    double sum = 0;
    int n = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (arrived(samples[i], p)) {
        sum += samples[i].z[p];
        ++n;
      }
      if (n > 0) statistics.running_mean[i * n_positions + p] = sum / n;
    }
    statistics.reached[p] = n;
    if (n == 0) continue;
    const double mean = sum / n;
    statistics.z_mean[p] = mean;
    if (n < 2) continue;
    double squares = 0;
    for (const SampleSummary& sample : samples) {
      if (arrived(sample, p)) squares += (sample.z[p] - mean) * (sample.z[p] - mean);
    }
    statistics.z_std[p] = std::sqrt(squares / (n - 1));
    statistics.z_half_width[p] = student_half_width(statistics.z_std[p], n, confidence);
  }
  return statistics;
}

Statistics make_statistics(std::span<const SampleSummary> samples, const input::Parameters& parameters) {
  const auto& stop = parameters.ensemble.stop;
  return make_statistics(samples, static_cast<int>(parameters.specimen.notches.size()),
                         static_cast<int>(parameters.sections.y.size()),
                         stop ? stop->confidence : default_confidence);
}

double quantile(std::vector<double> values, double share) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  if (values.empty()) return none;
  std::sort(values.begin(), values.end());
  const double rank = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(std::floor(rank));
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (rank - static_cast<double>(below)) * (values[above] - values[below]);
}

}  // namespace crackle::analysis
