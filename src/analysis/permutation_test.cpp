// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/permutation_test.h"

#include "analysis/grouped_values.h"
#include "common/random.h"
#include "common/real.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace crackle::analysis {

namespace {

constexpr int n_random_labels = 9999;
constexpr double max_exact_labels = 20'000;

/// The values of a group.
struct Sum {
  double n = 0, sum = 0;
};

using Labels = std::vector<std::uint8_t>;  ///< of each group: 1 for the second list

void add_sums(const std::vector<double>& values, Groups groups, std::vector<Sum>& sums) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i == 0 || group_of(groups, i) != group_of(groups, i - 1)) sums.emplace_back();
    sums.back().n += 1;
    sums.back().sum += values[i];
  }
}

/// Welch's statistic under other labels; for groups with standard errors as in GroupedMoments.
double studentized(const std::vector<Sum>& sums, const Labels& labels) {
  std::array<double, 2> n{}, sum{}, square{}, count{};
  for (std::size_t i = 0; i < sums.size(); ++i) {
    n[labels[i]] += sums[i].n;
    sum[labels[i]] += sums[i].sum;
    count[labels[i]] += 1;
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const std::size_t k = labels[i];
    square[k] += std::pow(sums[i].sum - sums[i].n * sum[k] / n[k], 2);
  }
  const auto of_mean = [&](std::size_t k) {
    return count[k] > 1 ? square[k] * count[k] / ((count[k] - 1) * n[k] * n[k]) : 0;
  };
  // A single group has no variance; that of the other list's groups is used instead.
  const auto error = [&](std::size_t k) {
    return count[k] == 1 ? count[1 - k] * of_mean(1 - k) : of_mean(k);
  };
  const double difference = sum[1] / n[1] - sum[0] / n[0], square_error = error(0) + error(1);
  if (difference == 0) return 0;
  return square_error > 0 ? std::abs(difference) / std::sqrt(square_error) : infinity;
}

/// Number of assignments; not exact above max_exact_labels.
double n_labellings(std::size_t n_first, std::size_t n_second) {
  double n = 1;
  for (std::size_t i = 1; i <= n_second && n <= max_exact_labels; ++i)
    n *= static_cast<double>(n_first + i) / static_cast<double>(i);
  return n;
}

}  // namespace

double permutation_probability(const TwoSamples& samples) {
  if (samples.first.empty() || samples.second.empty()) return 1;
  std::vector<Sum> sums;
  add_sums(samples.first, samples.first_group, sums);
  const std::size_t n_first = sums.size();
  add_sums(samples.second, samples.second_group, sums);
  Labels labels(sums.size(), 0);
  std::fill(labels.begin() + static_cast<std::ptrdiff_t>(n_first), labels.end(), 1);

  const double observed = studentized(sums, labels);
  // Statistics that differ by rounding only are equal.
  const double least = std::isinf(observed) ? observed : observed * (1 - 1e-9);
  double n = 0, n_as_large = 0;
  const auto visit = [&] {
    n += 1;
    n_as_large += studentized(sums, labels) >= least ? 1 : 0;
  };
  if (n_labellings(n_first, sums.size() - n_first) <= max_exact_labels) {
    do visit();
    while (std::next_permutation(labels.begin(), labels.end()));
    return n_as_large / n;
  }
  RandomStream stream(0, 0, "permutation test");
  for (int k = 0; k < n_random_labels; ++k) {
    for (std::size_t i = labels.size(); i > 1; --i)
      std::swap(labels[i - 1], labels[static_cast<std::size_t>(stream.uniform() * static_cast<double>(i))]);
    visit();
  }
  return (n_as_large + 1) / (n + 1);
}

}  // namespace crackle::analysis
