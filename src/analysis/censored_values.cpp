// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/censored_values.h"

#include "common/index.h"
#include "common/real.h"

#include <numeric>
#include <utility>

namespace crackle::analysis {

namespace {

/// Values in ascending order; of equal ones those that are bounds last.
std::vector<std::size_t> in_order(const CensoredValues& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(
      order, {}, [&](std::size_t i) { return std::pair(values.value[i], bool(values.is_bound[i])); });
  return order;
}

/// The values at a step of Kaplan and Meier's estimate.
struct Step {
  double value, n, n_at_risk;
};

/// Those up to a limit, or all below it.
std::vector<Step> steps_of(const CensoredValues& values, double limit, bool with_limit) {
  const std::vector<std::size_t> order = in_order(values);
  std::vector<Step> steps;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const double value = values.value[order[k]];
    if (values.is_bound[order[k]] || value > limit || (value == limit && !with_limit)) continue;
    if (steps.empty() || steps.back().value != value)
      steps.push_back({value, 0, static_cast<double>(order.size() - k)});
    steps.back().n += 1;
  }
  return steps;
}

double product(std::span<const Step> steps) {
  double share = 1;
  for (const Step& step : steps) share *= 1 - step.n / step.n_at_risk;
  return share;
}

/// Variance of the logarithm of the product.
double relative_variance(const CensoredValues& values, std::span<const Step> steps) {
  if (std::ranges::adjacent_find(values.group) == values.group.end()) {
    double sum = 0;
    for (const Step& step : steps) sum += step.n / (step.n_at_risk * (step.n_at_risk - step.n));
    return sum;
  }
  double sum = 0, of_group = 0, n_groups = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (const Step& step : steps) {
      if (values.value[i] < step.value) break;
      const bool is_here = !values.is_bound[i] && values.value[i] == step.value;
      of_group += ((is_here ? 1 : 0) - step.n / step.n_at_risk) / (step.n_at_risk - step.n);
    }
    if (i + 1 < values.size() && values.group[i + 1] == values.group[i]) continue;
    sum += of_group * of_group;
    of_group = 0;
    n_groups += 1;
  }
  return n_groups > 1 ? sum * n_groups / (n_groups - 1) : not_a_number;
}

/// Kaplan and Meier's share of values above the steps, with its interval.
struct Survival {
  double share;
  Interval interval;
};

/// @param n_known values that are known to lie on either side
Survival survival(const CensoredValues& values, std::span<const Step> steps, double n_known,
                  double confidence) {
  const double share = product(steps);
  const bool is_inside = share > 0 && share < 1;
  const double n_effective =
      is_inside ? (1 - share) / share / relative_variance(values, steps) : std::max(1.0, n_known);
  if (std::isnan(n_effective)) return {share, {0, 1}};
  const WilsonInterval wilson = wilson_interval(share, n_effective, confidence);
  return {share,
          {share == 0 ? 0 : std::max(0.0, wilson.centre - wilson.half_width),
           share == 1 ? 1 : std::min(1.0, wilson.centre + wilson.half_width)}};
}

/// True if a value is greater than a bound, so that the order of the values is not known.
bool is_mixed(const CensoredValues& values) {
  double least_bound = infinity, most = -infinity;
  for (std::size_t i = 0; i < values.size(); ++i)
    values.is_bound[i] ? least_bound = std::min(least_bound, values.value[i])
                       : most = std::max(most, values.value[i]);
  return most > least_bound;
}

}  // namespace

void CensoredValues::add(const Observation& one, std::size_t of_group) {
  if (std::isnan(one.value)) return;
  value.push_back(one.value);
  is_bound.push_back(one.is_bound);
  group.push_back(of_group);
}

CensoredShare censored_share(const CensoredValues& values, double limit, bool is_above, double confidence) {
  CensoredShare found;
  std::vector<double> hits;
  double most = -infinity;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool is_unknown = values.is_bound[i] && values.value[i] < limit;
    const bool is_hit = is_above ? values.value[i] > limit || (values.is_bound[i] && !is_unknown)
                                 : values.value[i] < limit && !values.is_bound[i];
    hits.push_back(is_hit ? 1 : 0);
    found.n_hits += is_hit ? 1 : 0;
    found.n_unknown += is_unknown ? 1 : 0;
    most = std::max(most, values.value[i]);
  }
  const auto n = static_cast<double>(values.size());
  found.least = found.n_hits / n;
  found.most = (found.n_hits + found.n_unknown) / n;
  if (found.n_unknown == 0) {
    found.share = found.least;
    found.interval = share_interval(hits, values.group, confidence);
    return found;
  }
  const std::vector<Step> steps = steps_of(values, limit, is_above);
  auto [share, interval] = survival(values, steps, n - found.n_unknown, confidence);
  const bool is_beyond = most < limit && share > 0;  // the largest value is a bound
  if (is_beyond) interval.lower = 0;
  if (!is_above) {
    share = 1 - share;
    interval = {1 - interval.upper, 1 - interval.lower};
  }
  if (!is_beyond) found.share = share;
  found.interval = interval;
  return found;
}

Observation censored_quantile(const CensoredValues& values, double share) {
  const double plain = quantile(values.value, share);
  if (values.size() == 0) return {};
  if (values.n_bounds() == 0) return {plain};
  if (!is_mixed(values)) {
    const double rank = share * static_cast<double>(values.size() - 1);
    const auto n_known = static_cast<double>(values.size()) - values.n_bounds();
    return {plain, std::ceil(rank) >= n_known};
  }
  const std::vector<Step> steps = steps_of(values, infinity, true);
  // The least value may lie anywhere above a bound below all others.
  if (share == 0 && plain < steps.front().value) return {plain, true};
  double left = 1;
  for (const Step& step : steps) {
    left *= 1 - step.n / step.n_at_risk;
    // Rounding of the product.
    if (left <= 1 - share + 1e-12) return {step.value};
  }
  return {plain, true};
}

std::array<Observation, 2> censored_median_interval(const CensoredValues& values, double confidence) {
  const auto [lower, upper] = median_interval(values.value, values.group, confidence);
  std::array<Observation, 2> ends{Observation{lower}, Observation{upper}};
  if (values.n_bounds() == 0 || std::isnan(lower)) return ends;
  if (!is_mixed(values)) {
    double least_bound = infinity;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (values.is_bound[i]) least_bound = std::min(least_bound, values.value[i]);
    for (Observation& end : ends) end.is_bound = end.value >= least_bound;
    return ends;
  }
  const std::vector<Step> steps = steps_of(values, infinity, true);
  for (Observation& end : ends) end.is_bound = true;
  for (std::size_t k = 0; k < steps.size() && ends[1].is_bound; ++k) {
    const double n_known = static_cast<double>(values.size());
    const auto [share, interval] = survival(values, std::span(steps).first(k + 1), n_known, confidence);
    for (auto [end, left] : {std::pair(&ends[0], interval.lower), std::pair(&ends[1], interval.upper)})
      if (end->is_bound && left <= 0.5) *end = {steps[k].value};
  }
  return ends;
}

std::array<std::vector<double>, 2> censored_scores(const CensoredValues& first,
                                                   const CensoredValues& second) {
  std::vector<double> known, bounds;
  for (const CensoredValues* list : {&first, &second})
    for (std::size_t i = 0; i < list->size(); ++i)
      (list->is_bound[i] ? bounds : known).push_back(list->value[i]);
  std::ranges::sort(known);
  std::ranges::sort(bounds);
  std::array<std::vector<double>, 2> scores;
  for (const bool is_first : {true, false}) {
    const CensoredValues& list = is_first ? first : second;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const double value = list.value[i];
      const auto n_up_to = std::ranges::upper_bound(known, value) - known.begin();
      const auto n_below = std::ranges::lower_bound(known, value) - known.begin();
      // What is bounded by the value lies above it.
      const auto n_above =
          std::ssize(known) - n_up_to + (bounds.end() - std::ranges::lower_bound(bounds, value));
      scores[is_first ? 0 : 1].push_back(static_cast<double>(list.is_bound[i] ? n_up_to : n_below - n_above));
    }
  }
  return scores;
}

}  // namespace crackle::analysis
