// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/comparison.h"
#include "crackle/analysis/running_statistics.h"
#include "crackle/common/index.h"
#include "crackle/common/random.h"
#include "crackle/common/real.h"

#include <boost/math/distributions/students_t.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <utility>

namespace crackle::analysis {

namespace {

constexpr int n_bootstrap_samples = 4000;
constexpr int n_random_labels = 9999;
constexpr double max_exact_labels = 20'000;
/// Tolerance below which statistics are equal up to rounding.
constexpr double rounding = 1e-9;

Moments moments_of(std::span<const double> values) {
  Moments moments;
  for (const double value : values) moments.add(value);
  return moments;
}

double square_error(const Moments& moments) {
  return moments.standard_deviation() * moments.standard_deviation() / moments.count();
}

std::vector<double> differences_of(const TwoSamples& samples) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < samples.first.size(); ++i)
    differences.push_back(samples.second[i] - samples.first[i]);
  return differences;
}

/// Difference over its standard error; 0 or infinity without scatter.
double studentized(double difference, double square_error) {
  if (difference == 0) return 0;
  return square_error > 0 ? std::abs(difference) / std::sqrt(square_error) : infinity;
}

/// Calls visit(labels) for each assignment of labels: all of them, or random ones. Label 1 means the second
/// list; labels are in the order of all values of the first and then of the second list. For pairs, a label
/// of 1 swaps the pair.
/// @return true if all assignments were visited
template <class Visit>
bool for_each_labelling(std::size_t n_first, std::size_t n_second, bool are_paired, const Visit& visit) {
  const std::size_t n = n_first + n_second;
  std::vector<std::uint8_t> labels(n, 0);
  const auto start = labels.begin() + static_cast<std::ptrdiff_t>(n_first);
  std::fill(start, labels.end(), 1);
  RandomStream stream(0, 0, "permutation test");
  if (are_paired) {
    const auto give = [&](std::size_t pair, bool changes_places) {
      labels[pair] = changes_places;
      labels[n_first + pair] = !changes_places;
    };
    if (std::ldexp(1.0, static_cast<int>(std::min<std::size_t>(n_first, 1000))) <= max_exact_labels) {
      for (std::uint64_t k = 0; k < (std::uint64_t{1} << n_first); ++k) {
        for (std::size_t pair = 0; pair < n_first; ++pair) give(pair, (k >> pair & 1) != 0);
        visit(labels);
      }
      return true;
    }
    for (int k = 0; k < n_random_labels; ++k) {
      for (std::size_t pair = 0; pair < n_first; ++pair) give(pair, (stream.bits() & 1) != 0);
      visit(labels);
    }
    return false;
  }
  double n_ways = 1;
  for (std::size_t i = 1; i <= n_second && n_ways <= max_exact_labels; ++i)
    n_ways *= static_cast<double>(n_first + i) / static_cast<double>(i);
  if (n_ways <= max_exact_labels) {
    do visit(labels);
    while (std::next_permutation(labels.begin(), labels.end()));
    return true;
  }
  for (int k = 0; k < n_random_labels; ++k) {
    for (std::size_t i = n; i > 1; --i)
      std::swap(labels[i - 1], labels[static_cast<std::size_t>(stream.uniform() * static_cast<double>(i))]);
    visit(labels);
  }
  return false;
}

/// The share of assignments whose statistic is at least as large as the observed one, which is included.
template <class Statistic>
double share_as_large(std::size_t n_first, std::size_t n_second, bool are_paired,
                      const Statistic& statistic) {
  std::vector<std::uint8_t> observed(n_first + n_second, 0);
  std::fill(observed.begin() + static_cast<std::ptrdiff_t>(n_first), observed.end(), 1);
  const double found = statistic(observed);
  const double threshold = std::isinf(found) ? found : found - rounding * std::abs(found);
  std::int64_t n = 0, n_as_large = 0;
  const bool are_all = for_each_labelling(n_first, n_second, are_paired, [&](const auto& labels) {
    const double value = statistic(labels);
    ++n;
    n_as_large += value >= threshold ? 1 : 0;
  });
  if (are_all) return static_cast<double>(n_as_large) / static_cast<double>(n);
  return static_cast<double>(n_as_large + 1) / static_cast<double>(n + 1);
}

double student(double confidence, double degrees) {
  return boost::math::quantile(boost::math::students_t(degrees), (1 + confidence) / 2);
}

}  // namespace

Difference difference_of_means(const TwoSamples& samples, double confidence) {
  Difference found;
  double error = not_a_number, degrees = 0;
  if (samples.are_paired) {
    const Moments m = moments_of(differences_of(samples));
    found.value = m.mean();
    error = std::sqrt(square_error(m));
    degrees = m.count() - 1;
  } else {
    const Moments a = moments_of(samples.first), b = moments_of(samples.second);
    found.value = b.mean() - a.mean();
    const double of_a = square_error(a), of_b = square_error(b);
    error = std::sqrt(of_a + of_b);
    degrees = error > 0 ? (of_a + of_b) * (of_a + of_b) /
                              (of_a * of_a / (a.count() - 1) + of_b * of_b / (b.count() - 1))
                        : a.count() + b.count() - 2;
  }
  if (std::isnan(error)) return found;
  const double half_width = student(confidence, degrees) * error;
  return {found.value, found.value - half_width, found.value + half_width};
}

Difference difference_of_medians(const TwoSamples& samples, double confidence) {
  const std::vector<double> differences =
      samples.are_paired ? differences_of(samples) : std::vector<double>{};
  const auto of = [&](const auto& first, const auto& second) {
    return samples.are_paired ? quantile(first, 0.5) : quantile(second, 0.5) - quantile(first, 0.5);
  };
  const auto& one = samples.are_paired ? differences : samples.first;
  const auto& other = samples.are_paired ? differences : samples.second;
  Difference found{of(one, other)};
  if (one.size() < 2 || other.size() < 2) return found;
  RandomStream stream(0, 0, "bootstrap of medians");
  const auto draw = [&](const std::vector<double>& values) {
    std::vector<double> drawn(values.size());
    for (double& value : drawn)
      value = values[static_cast<std::size_t>(stream.uniform() * static_cast<double>(values.size()))];
    return drawn;
  };
  std::vector<double> medians;
  for (int k = 0; k < n_bootstrap_samples; ++k) {
    const std::vector<double> first = draw(one);
    medians.push_back(of(first, samples.are_paired ? first : draw(other)));
  }
  found.lower = quantile(medians, (1 - confidence) / 2);
  found.upper = quantile(medians, (1 + confidence) / 2);
  return found;
}

Difference difference_of_shares(const TwoSamples& samples, double confidence) {
  const Moments a = moments_of(samples.first), b = moments_of(samples.second);
  Difference found{b.mean() - a.mean()};
  if (samples.first.empty() || samples.second.empty()) return found;
  const auto interval = [&](const std::vector<double>& values) {
    return share_interval(static_cast<int>(std::ranges::count(values, 1.0)), static_cast<int>(values.size()),
                          confidence);
  };
  const Interval of_a = interval(samples.first), of_b = interval(samples.second);
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
    if (excess > 0) excess = std::max(0.0, excess - a.count() / 2.0);
    if (margins > 0) correlation = excess / std::sqrt(margins);
  }
  const auto reach = [&](double of_one, double of_other) {
    return std::sqrt(
        std::max(0.0, of_one * of_one - 2 * correlation * of_one * of_other + of_other * of_other));
  };
  found.lower = found.value - reach(b.mean() - of_b.lower, of_a.upper - a.mean());
  found.upper = found.value + reach(of_b.upper - b.mean(), a.mean() - of_a.lower);
  return found;
}

double permutation_probability(const TwoSamples& samples) {
  const std::size_t n_first = samples.first.size(), n_second = samples.second.size();
  if (n_first == 0 || n_second == 0) return 1;
  std::vector<double> values = samples.first;
  values.insert(values.end(), samples.second.begin(), samples.second.end());
  return share_as_large(n_first, n_second, samples.are_paired, [&](const std::vector<std::uint8_t>& labels) {
    if (samples.are_paired) {
      double sum = 0, squares = 0;
      for (std::size_t i = 0; i < n_first; ++i) {
        const double d = (labels[i] != 0 ? -1 : 1) * (values[n_first + i] - values[i]);
        sum += d;
        squares += d * d;
      }
      const double n = static_cast<double>(n_first);
      return studentized(sum / n, std::max(0.0, squares - sum * sum / n) / n);
    }
    std::array<double, 2> n{}, mean{}, square{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      n[labels[i]] += 1;
      mean[labels[i]] += values[i];
    }
    for (std::size_t k = 0; k < 2; ++k) mean[k] /= n[k];
    for (std::size_t i = 0; i < values.size(); ++i)
      square[labels[i]] += std::pow(values[i] - mean[labels[i]], 2);
    // A single value has no variance; the other list's is used instead.
    const auto error = [&](std::size_t k) { return square[k] / (std::max(1.0, n[k] - 1) * n[k]); };
    return studentized(mean[1] - mean[0], error(0) + error(1));
  });
}

namespace {

using Path = std::vector<double>;

/// Root mean square of one + sign other over the sections that both reach; empty if there are none.
std::optional<double> path_distance(const Path& one, const Path& other, double sign) {
  double square = 0, n_common = 0;
  for (std::size_t s = 0; s < one.size(); ++s) {
    const double difference = one[s] + sign * other[s];
    if (std::isnan(difference)) continue;
    square += difference * difference;
    n_common += 1;
  }
  if (n_common == 0) return {};
  return std::sqrt(square / n_common);
}

/// Energy distance between the differences of pairs and their mirror images: 2 E|D + D'| - 2 E|D - D'|.
EnergyDistance energy_distance_of_pairs(const TwoGroupsOfPaths& paths) {
  std::vector<Path> differences;
  for (std::size_t i = 0; i < paths.first.size(); ++i) {
    Path& difference = differences.emplace_back(paths.second[i]);
    for (std::size_t s = 0; s < difference.size(); ++s) difference[s] -= paths.first[i][s];
  }
  const std::size_t n = differences.size();
  std::vector<double> terms(n * n, 0);
  double n_known = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n; ++k) {
      const auto sum = path_distance(differences[i], differences[k], 1);
      if (!sum) continue;
      terms[i * n + k] = *sum - *path_distance(differences[i], differences[k], -1);
      n_known += 1;
    }
  }
  if (n_known == 0) return {};
  // Swapping a pair changes the sign of its difference.
  const auto statistic = [&](const std::vector<std::uint8_t>& labels) {
    double total = 0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < n; ++k)
        total += labels[i] == labels[k] ? terms[i * n + k] : -terms[i * n + k];
    return 2 * total / n_known;
  };
  return {statistic(std::vector<std::uint8_t>(n, 0)), share_as_large(n, n, true, statistic)};
}

}  // namespace

EnergyDistance energy_distance(const TwoGroupsOfPaths& paths) {
  const std::size_t n_first = paths.first.size(), n_second = paths.second.size(), n = n_first + n_second;
  if (n_first < 2 || n_second < 2) return {};
  if (paths.are_paired) return energy_distance_of_pairs(paths);
  const auto path = [&](std::size_t i) -> const auto& {
    return i < n_first ? paths.first[i] : paths.second[i - n_first];
  };
  std::vector<double> distance(n * n, 0);
  std::vector<double> is_known(n * n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = i + 1; k < n; ++k) {
      const auto found = path_distance(path(i), path(k), -1);
      if (!found) continue;
      distance[i * n + k] = *found;
      is_known[i * n + k] = 1;
    }
  }
  const auto statistic = [&](const std::vector<std::uint8_t>& labels) {
    std::array<double, 3> sum{}, count{};  // within the first group, between groups, within the second
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = i + 1; k < n; ++k) {
        const std::size_t which = labels[i] + labels[k];
        sum[which] += distance[i * n + k];
        count[which] += is_known[i * n + k];
      }
    }
    for (const double one : count)
      if (one == 0) return 0.0;
    // Averages over all pairs including each path with itself, estimated from the available ones.
    const auto share_of_others = [](std::size_t size) { return 1 - 1 / static_cast<double>(size); };
    return 2 * sum[1] / count[1] - share_of_others(n_first) * sum[0] / count[0] -
           share_of_others(n_second) * sum[2] / count[2];
  };
  std::vector<std::uint8_t> observed(n, 0);
  std::fill(observed.begin() + static_cast<std::ptrdiff_t>(n_first), observed.end(), 1);
  return {statistic(observed), share_as_large(n_first, n_second, false, statistic)};
}

std::vector<double> adjusted_for_comparisons(std::span<const double> probabilities) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < probabilities.size(); ++i)
    if (!std::isnan(probabilities[i])) order.push_back(i);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return probabilities[i]; });
  std::vector<double> adjusted(probabilities.begin(), probabilities.end());
  double least = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    least = std::max(least, std::min(1.0, static_cast<double>(order.size() - k) * probabilities[order[k]]));
    adjusted[order[k]] = least;
  }
  return adjusted;
}

}  // namespace crackle::analysis
