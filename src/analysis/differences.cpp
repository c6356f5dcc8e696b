// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/comparison.h"
#include "crackle/analysis/grouped_values.h"
#include "crackle/common/real.h"

#include <boost/math/distributions/students_t.hpp>

#include <algorithm>
#include <cmath>
#include <functional>

namespace crackle::analysis {

namespace {

struct MeanEstimate {
  double mean, square_error, degrees;
};

MeanEstimate estimate_mean(const std::vector<double>& values, Groups groups) {
  if (!groups.empty()) {
    GroupedMoments moments;
    for (std::size_t i = 0; i < values.size(); ++i) moments.add(values[i], groups[i]);
    return {moments.mean(), moments.square_error(), moments.n_groups() - 1.0};
  }
  Moments moments;
  for (const double value : values) moments.add(value);
  const double deviation = moments.standard_deviation();
  return {moments.mean(), deviation * deviation / moments.count(), moments.count() - 1.0};
}

bool are_equal(const std::vector<double>& values) {
  return std::ranges::adjacent_find(values, std::ranges::not_equal_to{}) == values.end();
}

bool are_equal(const TwoSamples& samples) {
  if (samples.are_paired) return are_equal(samples.differences());
  return are_equal(samples.first) && are_equal(samples.second);
}

/// The difference without its interval if all values, or differences of pairs, are equal.
Difference unless_equal(const TwoSamples& samples, const Difference& found) {
  if (std::isnan(found.lower) || !are_equal(samples)) return found;
  return {found.value, not_a_number, not_a_number, true};
}

/// Ends of the interval of a difference from the intervals of both parts (Zou and Donner 2008, Stat. Med. 27,
/// 1693), which for shares are Newcombe's.
Difference combined(double first, const Interval& of_first, double second, const Interval& of_second,
                    double correlation) {
  const auto reach = [&](double of_one, double of_other) {
    return std::sqrt(
        std::max(0.0, of_one * of_one - 2 * correlation * of_one * of_other + of_other * of_other));
  };
  const double value = second - first;
  if (std::isnan(of_first.lower) || std::isnan(of_second.lower)) return {value};
  return {value, value - reach(second - of_second.lower, of_first.upper - first),
          value + reach(of_second.upper - second, first - of_first.lower)};
}

}  // namespace

std::vector<double> TwoSamples::differences() const {
  std::vector<double> found;
  for (std::size_t i = 0; i < first.size(); ++i) found.push_back(second[i] - first[i]);
  return found;
}

Difference difference_of_means(const TwoSamples& samples, double confidence) {
  MeanEstimate found{};
  if (samples.are_paired) {
    found = estimate_mean(samples.differences(), samples.first_group);
  } else {
    const MeanEstimate a = estimate_mean(samples.first, samples.first_group);
    const MeanEstimate b = estimate_mean(samples.second, samples.second_group);
    found = {b.mean - a.mean, a.square_error + b.square_error, a.degrees + b.degrees};
    if (found.square_error > 0)
      found.degrees = std::pow(found.square_error, 2) /
                      (std::pow(a.square_error, 2) / a.degrees + std::pow(b.square_error, 2) / b.degrees);
  }
  if (std::isnan(found.square_error)) return {found.mean};
  const double half_width =
      boost::math::quantile(boost::math::students_t(found.degrees), (1 + confidence) / 2) *
      std::sqrt(found.square_error);
  return unless_equal(samples, {found.mean, found.mean - half_width, found.mean + half_width});
}

Difference difference_of_medians(const TwoSamples& samples, double confidence) {
  if (samples.are_paired) {
    const std::vector<double> differences = samples.differences();
    const Interval interval = median_interval(differences, samples.first_group, confidence);
    return unless_equal(samples, {quantile(differences, 0.5), interval.lower, interval.upper});
  }
  return unless_equal(
      samples,
      combined(quantile(samples.first, 0.5), median_interval(samples.first, samples.first_group, confidence),
               quantile(samples.second, 0.5),
               median_interval(samples.second, samples.second_group, confidence), 0));
}

Difference difference_of_medians(const CensoredValues& first, const CensoredValues& second,
                                 double confidence) {
  const auto one = censored_quantile(first, 0.5), other = censored_quantile(second, 0.5);
  if (one.is_bound || other.is_bound) return {};
  const auto interval_of = [&](const CensoredValues& values) {
    const auto [lower, upper] = censored_median_interval(values, confidence);
    return Interval{lower.value, upper.is_bound ? infinity : upper.value};
  };
  return combined(one.value, interval_of(first), other.value, interval_of(second), 0);
}

Difference difference_of_shares(const TwoSamples& samples, double confidence) {
  const MeanEstimate a = estimate_mean(samples.first, {}), b = estimate_mean(samples.second, {});
  if (samples.first.empty() || samples.second.empty()) return {b.mean - a.mean};
  double correlation = 0;
  if (samples.are_paired) {
    double both = 0, only_first = 0, only_second = 0, none = 0;
    for (std::size_t i = 0; i < samples.first.size(); ++i) {
      const bool first = samples.first[i] == 1, second = samples.second[i] == 1;
      (first ? second ? both : only_first : second ? only_second : none) += 1;
    }
    const double margins =
        (both + only_first) * (only_second + none) * (both + only_second) * (only_first + none);
    double excess = both * none - only_first * only_second;
    // Newcombe's continuity correction.
    if (excess > 0) excess = std::max(0.0, excess - static_cast<double>(samples.first.size()) / 2);
    if (margins > 0) correlation = excess / std::sqrt(margins);
  }
  return combined(a.mean, share_interval(samples.first, samples.first_group, confidence), b.mean,
                  share_interval(samples.second, samples.second_group, confidence), correlation);
}

}  // namespace crackle::analysis
