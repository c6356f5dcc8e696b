// SPDX-License-Identifier: GPL-3.0-or-later
#include "permutations.h"

#include "crackle/common/random.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace crackle::analysis {

namespace {

constexpr int n_random_labels = 9999;
constexpr double max_exact_labels = 20'000;

/// Number of assignments; not exact above max_exact_labels.
double n_labellings(const Design& design) {
  if (design.are_paired)
    return std::ldexp(1.0, static_cast<int>(std::min<std::size_t>(design.n_first, 1000)));
  double n = 1;
  for (std::size_t i = 1; i <= design.n_second && n <= max_exact_labels; ++i)
    n *= static_cast<double>(design.n_first + i) / static_cast<double>(i);
  return n;
}

/// Statistics that differ by rounding only are equal.
double threshold(double observed) {
  constexpr double rounding = 1e-9;
  return std::isinf(observed) ? observed : observed - rounding * std::abs(observed);
}

/// Statistics of all looks, under the observed labels and under the others.
struct Reference {
  std::vector<double> observed;
  std::vector<std::vector<double>> values;  ///< assignments x looks
  bool are_all = false;
};

Reference reference_of(const Design& design, std::span<const Look> looks) {
  const auto all = [&](const Labels& labels) {
    std::vector<double> values;
    for (const Look& look : looks) values.push_back(std::max(0.0, look.statistic(labels)));
    return values;
  };
  Reference found{all(observed_labels(design)), {}, false};
  found.are_all =
      for_each_labelling(design, [&](const Labels& labels) { found.values.push_back(all(labels)); });
  for (std::size_t k = 0; k < looks.size(); ++k) {
    if (!looks[k].is_distance) continue;
    double mean = 0;
    for (const auto& row : found.values) mean += row[k] / static_cast<double>(found.values.size());
    const auto scale = [&](double& value) { value = mean > 0 ? std::sqrt(value / mean) : 0; };
    scale(found.observed[k]);
    for (auto& row : found.values) scale(row[k]);
  }
  return found;
}

}  // namespace

Labels observed_labels(const Design& design) {
  Labels labels(design.n_units(), 0);
  std::fill(labels.begin() + static_cast<std::ptrdiff_t>(design.n_first), labels.end(), 1);
  return labels;
}

bool for_each_labelling(const Design& design, const std::function<void(const Labels&)>& visit) {
  Labels labels = observed_labels(design);
  const bool are_all = n_labellings(design) <= max_exact_labels;
  RandomStream stream(0, 0, "permutation test");
  if (design.are_paired && are_all) {
    for (std::uint64_t k = 0; k < (std::uint64_t{1} << labels.size()); ++k) {
      for (std::size_t pair = 0; pair < labels.size(); ++pair) labels[pair] = (k >> pair & 1) != 0;
      visit(labels);
    }
  } else if (are_all) {
    do visit(labels);
    while (std::next_permutation(labels.begin(), labels.end()));
  } else {
    for (int k = 0; k < n_random_labels; ++k) {
      if (design.are_paired)
        for (auto& label : labels) label = (stream.bits() & 1) != 0;
      else
        for (std::size_t i = labels.size(); i > 1; --i)
          std::swap(labels[i - 1],
                    labels[static_cast<std::size_t>(stream.uniform() * static_cast<double>(i))]);
      visit(labels);
    }
  }
  return are_all;
}

double least_probability(const Design& design) {
  const double n = n_labellings(design);
  if (n > max_exact_labels) return 1.0 / (n_random_labels + 1);
  // A mirror image of the observed labels has the same two-sided statistic.
  return std::min(1.0, (design.are_paired || design.n_first == design.n_second ? 2 : 1) / n);
}

double share_as_large(const Design& design, const LabelStatistic& statistic) {
  const double least = threshold(statistic(observed_labels(design)));
  std::int64_t n = 0, n_as_large = 0;
  const bool are_all = for_each_labelling(design, [&](const Labels& labels) {
    ++n;
    n_as_large += statistic(labels) >= least ? 1 : 0;
  });
  const int own = are_all ? 0 : 1;
  return static_cast<double>(n_as_large + own) / static_cast<double>(n + own);
}

std::vector<double> step_down_max_t(const Design& design, std::span<const Look> looks) {
  const Reference reference = reference_of(design, looks);
  std::vector<std::size_t> order(looks.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::ranges::greater{},
                           [&](std::size_t look) { return reference.observed[look]; });
  std::vector<std::int64_t> n_as_large(looks.size(), reference.are_all ? 0 : 1);
  for (const auto& values : reference.values) {
    double largest = 0;  // over this look and those with a smaller observed statistic
    for (std::size_t k = order.size(); k-- > 0;) {
      largest = std::max(largest, values[order[k]]);
      n_as_large[order[k]] += largest >= threshold(reference.observed[order[k]]) ? 1 : 0;
    }
  }
  const double n = static_cast<double>(reference.values.size()) + (reference.are_all ? 0 : 1);
  std::vector<double> adjusted(looks.size());
  double least = 0;
  for (const std::size_t look : order)
    adjusted[look] = least = std::max(least, static_cast<double>(n_as_large[look]) / n);
  return adjusted;
}

}  // namespace crackle::analysis
