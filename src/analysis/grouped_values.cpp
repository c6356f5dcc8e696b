// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/grouped_values.h"
#include "common/index.h"
#include "common/real.h"

#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/students_t.hpp>

#include <algorithm>
#include <cmath>

namespace crackle::analysis {

namespace {

/// Calls visit(begin, end) for the range of each group.
template <class Visit>
void for_each_group(std::size_t n_values, Groups groups, const Visit& visit) {
  for (std::size_t begin = 0, end = 0; begin < n_values; begin = end) {
    end = begin + 1;
    while (!groups.empty() && end < n_values && groups[end] == groups[begin]) ++end;
    visit(begin, end);
  }
}

std::size_t n_groups_of(std::size_t n_values, Groups groups) {
  std::size_t n = 0;
  for_each_group(n_values, groups, [&](std::size_t, std::size_t) { ++n; });
  return n;
}

}  // namespace

VarianceComponents variance_components(std::span<const double> values, Groups groups,
                                       std::span<const double> times) {
  double n = 0, sum = 0;
  const auto times_of = [&](std::size_t i) { return times.empty() ? 1.0 : times[i]; };
  for (std::size_t i = 0; i < values.size(); ++i) {
    n += times_of(i);
    sum += times_of(i) * values[i];
  }
  double within = 0, between = 0, n_groups = 0, squares = 0;
  VarianceComponents found;
  for_each_group(values.size(), groups, [&](std::size_t begin, std::size_t end) {
    const auto own = values.subspan(begin, end - begin);
    const auto size = static_cast<double>(own.size());
    double mean = 0, square = 0;
    for (const double value : own) mean += value / size;
    for (const double value : own) square += (value - mean) * (value - mean);
    within += times_of(begin) * square;
    between += times_of(begin) * size * std::pow(mean - sum / n, 2);
    n_groups += times_of(begin);
    squares += times_of(begin) * size * size;
    ++found.n_groups;
  });
  if (n <= n_groups || n_groups < 2) return found;
  found.within = within / (n - n_groups);
  const double per_group = (n - squares / n) / (n_groups - 1);
  found.between = std::max(0.0, (between / (n_groups - 1) - found.within) / per_group);
  const double all = found.within + found.between;
  if (!(all > 0)) return found;
  found.intraclass = found.between / all;
  found.design_effect = 1 + (squares / n - 1) * found.intraclass;
  return found;
}

void GroupedMoments::close_group() {
  squares_n_ += own_n_ * own_n_;
  squares_sum_ += own_sum_ * own_sum_;
  products_ += own_n_ * own_sum_;
  own_n_ = own_sum_ = 0;
}

void GroupedMoments::add(double value, std::size_t group) {
  if (n_groups_ == 0) origin_ = value;
  if (n_groups_ == 0 || group != group_) {
    close_group();
    group_ = group;
    ++n_groups_;
  }
  own_n_ += 1;
  own_sum_ += value - origin_;
  n_ += 1;
  sum_ += value - origin_;
}

double GroupedMoments::mean() const {
  return n_ > 0 ? origin_ + sum_ / n_ : not_a_number;
}

double GroupedMoments::square_error() const {
  if (n_groups_ < 2) return not_a_number;
  GroupedMoments all = *this;
  all.close_group();
  const double mean = sum_ / n_;
  const double residuals = all.squares_sum_ - 2 * mean * all.products_ + mean * mean * all.squares_n_;
  return std::max(0.0, residuals) * n_groups_ / (n_groups_ - 1) / (n_ * n_);
}

MeanEstimate mean_estimate(std::span<const double> values, Groups groups, double confidence) {
  Moments moments;
  GroupedMoments grouped;
  for (std::size_t i = 0; i < values.size(); ++i) {
    moments.add(values[i]);
    grouped.add(values[i], group_of(groups, i));
  }
  MeanEstimate found{moments.mean(), moments.standard_deviation(), not_a_number};
  found.half_width =
      grouped.n_groups() < moments.count()
          ? student_quantile(grouped.n_groups(), confidence) * std::sqrt(grouped.square_error())
          : student_half_width(found.std, moments.count(), confidence);
  return found;
}

double independent_values(std::span<const double> values, Groups groups) {
  const auto n = static_cast<double>(values.size());
  const auto n_groups = static_cast<double>(n_groups_of(values.size(), groups));
  const VarianceComponents found = variance_components(values, groups);
  // Values that do not vary say nothing of how alike those of a group are.
  const double alike = !std::isnan(found.intraclass) ? found.intraclass : n_groups < n ? 1 : 0;
  return std::max(1.0, n / (1 + (n / n_groups - 1) * alike));
}

Interval share_interval(std::span<const double> values, Groups groups, double confidence) {
  const auto n_hits = static_cast<int>(std::ranges::count(values, 1.0));
  const auto n = static_cast<int>(values.size());
  const int n_independent = static_cast<int>(independent_values(values, groups));
  if (n_independent == n || n_hits == 0) return share_interval(n_hits, n_independent, confidence);
  if (n_hits == n) return share_interval(n_independent, n_independent, confidence);
  const WilsonInterval wilson = wilson_interval(static_cast<double>(n_hits) / n, n_independent, confidence);
  return {std::max(0.0, wilson.centre - wilson.half_width), std::min(1.0, wilson.centre + wilson.half_width)};
}

int least_values_for_median(double confidence) {
  return static_cast<int>(std::ceil(1 - std::log2(1 - confidence)));
}

Interval median_interval(std::span<const double> values, Groups groups, double confidence) {
  std::vector<double> sorted;
  std::vector<std::size_t> group;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    sorted.push_back(values[i]);
    if (!groups.empty()) group.push_back(groups[i]);
  }
  const std::vector<double> in_order = sorted;
  std::ranges::sort(sorted);
  const auto n = static_cast<double>(sorted.size());
  const std::size_t n_groups = n_groups_of(sorted.size(), group);
  if (n_groups < index(least_values_for_median(confidence))) return {not_a_number, not_a_number};
  double rank = 0;  // of the lower end, from 1
  if (n_groups == sorted.size()) {
    const boost::math::binomial law(n, 0.5);
    while (2 * boost::math::cdf(law, rank) <= 1 - confidence) rank += 1;
  } else {
    const double median = quantile(sorted, 0.5);
    GroupedMoments below;
    for (std::size_t i = 0; i < in_order.size(); ++i)
      below.add(in_order[i] < median ? 1 : in_order[i] == median ? 0.5 : 0, group[i]);
    const double t = boost::math::quantile(boost::math::students_t(static_cast<double>(n_groups - 1)),
                                           (1 + confidence) / 2);
    // From the least to the largest value, the interval holds with this many groups in any case.
    rank = std::max(1.0, std::floor(n * (0.5 - t * std::sqrt(below.square_error()))));
  }
  const auto lower = static_cast<std::size_t>(rank);
  return {sorted[lower - 1], sorted[sorted.size() - lower]};
}

}  // namespace crackle::analysis
