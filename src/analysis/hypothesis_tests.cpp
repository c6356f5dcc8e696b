// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/comparison.h"
#include "crackle/analysis/grouped_values.h"
#include "crackle/common/index.h"
#include "crackle/common/real.h"

#include "permutations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

namespace crackle::analysis {

namespace {

using Path = std::vector<double>;

/// Numbers of the units of a test: the groups of the values, those of the second list after the first's.
class Units {
public:
  template <class Lists>
  void add(const Lists& lists) {
    are_paired_ = lists.are_paired;
    collect(lists.first.size(), lists.first_group, first_);
    if (!are_paired_) collect(lists.second.size(), lists.second_group, second_);
  }

  Design design() const { return {first_.size(), second_.size(), are_paired_}; }
  std::size_t of_first(std::size_t group) const { return number(first_, group); }
  std::size_t of_second(std::size_t group) const {
    return are_paired_ ? of_first(group) : first_.size() + number(second_, group);
  }

private:
  static void collect(std::size_t n, const std::vector<std::size_t>& groups,
                      std::vector<std::size_t>& units) {
    for (std::size_t i = 0; i < n; ++i) units.push_back(group_of(groups, i));
    std::ranges::sort(units);
    units.erase(std::unique(units.begin(), units.end()), units.end());
  }
  static std::size_t number(const std::vector<std::size_t>& units, std::size_t group) {
    return static_cast<std::size_t>(std::ranges::lower_bound(units, group) - units.begin());
  }

  bool are_paired_ = false;
  std::vector<std::size_t> first_, second_;
};

template <class Lists>
Units units_of(const Lists& lists) {
  Units units;
  units.add(lists);
  return units;
}

/// Difference over its standard error; 0 or infinity without scatter.
double studentized(double difference, double square_error) {
  if (difference == 0) return 0;
  return square_error > 0 ? std::abs(difference) / std::sqrt(square_error) : infinity;
}

/// The studentized difference of the means under other labels: Welch's statistic or, for pairs, Student's of
/// the differences; for groups with standard errors as in GroupedMoments.
class MeanStatistic {
public:
  MeanStatistic(const TwoSamples& samples, const Units& units) : are_paired_(samples.are_paired) {
    if (are_paired_) {
      const std::vector<double> differences = samples.differences();
      for (std::size_t i = 0; i < differences.size(); ++i)
        add(units.of_first(group_of(samples.first_group, i)), differences[i]);
      return;
    }
    for (std::size_t i = 0; i < samples.first.size(); ++i)
      add(units.of_first(group_of(samples.first_group, i)), samples.first[i]);
    for (std::size_t i = 0; i < samples.second.size(); ++i)
      add(units.of_second(group_of(samples.second_group, i)), samples.second[i]);
  }

  double operator()(const Labels& labels) const {
    std::array<double, 2> n{}, sum{}, square{}, count{};
    const auto side = [&](const Sum& one) { return are_paired_ ? std::size_t{0} : labels[one.unit]; };
    const auto signed_sum = [&](const Sum& one) {
      return are_paired_ && labels[one.unit] != 0 ? -one.sum : one.sum;
    };
    for (const Sum& one : sums_) {
      n[side(one)] += one.n;
      sum[side(one)] += signed_sum(one);
      count[side(one)] += 1;
    }
    if (n[0] == 0 || (!are_paired_ && n[1] == 0)) return 0;
    const auto mean = [&](std::size_t k) { return n[k] > 0 ? sum[k] / n[k] : 0; };
    const std::array<double, 2> means{mean(0), mean(1)};
    for (const Sum& one : sums_) square[side(one)] += std::pow(signed_sum(one) - one.n * means[side(one)], 2);
    const auto of_mean = [&](std::size_t k) {
      return count[k] > 1 ? square[k] * count[k] / ((count[k] - 1) * n[k] * n[k]) : 0;
    };
    // A single unit has no variance; that of the other list's units is used instead.
    const auto error = [&](std::size_t k) {
      return count[k] == 1 ? count[1 - k] * of_mean(1 - k) : of_mean(k);
    };
    return studentized(means[1] - means[0], error(0) + error(1));
  }

private:
  struct Sum {
    std::size_t unit;
    double n, sum;
  };

  void add(std::size_t unit, double value) {
    if (sums_.empty() || sums_.back().unit != unit) sums_.push_back({unit, 0, 0});
    sums_.back().n += 1;
    sums_.back().sum += value;
  }

  bool are_paired_;
  std::vector<Sum> sums_;
};

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

/// The energy distance under other labels.
class EnergyStatistic {
public:
  EnergyStatistic(const TwoGroupsOfPaths& paths, const Units& units) : are_paired_(paths.are_paired) {
    std::vector<Path> all;
    for (std::size_t i = 0; i < paths.first.size(); ++i) {
      Path& path = all.emplace_back(paths.first[i]);
      unit_.push_back(units.of_first(group_of(paths.first_group, i)));
      if (!are_paired_) continue;
      for (std::size_t s = 0; s < path.size(); ++s) path[s] = paths.second[i][s] - path[s];
    }
    for (std::size_t i = 0; !are_paired_ && i < paths.second.size(); ++i) {
      all.push_back(paths.second[i]);
      unit_.push_back(units.of_second(group_of(paths.second_group, i)));
    }
    terms_.assign(all.size() * all.size(), 0);
    is_known_ = terms_;
    for (std::size_t i = 0; i < all.size(); ++i) {
      for (std::size_t k = 0; k < all.size(); ++k) {
        const auto distance = path_distance(all[i], all[k], -1);
        if (!distance || (i == k && !are_paired_)) continue;
        terms_[i * all.size() + k] = are_paired_ ? *path_distance(all[i], all[k], 1) - *distance : *distance;
        is_known_[i * all.size() + k] = 1;
        n_known_ += 1;
      }
    }
  }

  bool is_defined() const { return n_known_ > 0; }

  double operator()(const Labels& labels) const { return are_paired_ ? of_pairs(labels) : of_groups(labels); }

private:
  /// Between the differences and their mirror images, 2 E|D + D'| - 2 E|D - D'|: swapping a pair changes the
  /// sign of its difference.
  double of_pairs(const Labels& labels) const {
    const std::vector<std::uint8_t> label = by_path(labels);
    const std::size_t n = label.size();
    double total = 0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < n; ++k)
        total += label[i] == label[k] ? terms_[i * n + k] : -terms_[i * n + k];
    return 2 * total / n_known_;
  }

  double of_groups(const Labels& labels) const {
    const std::vector<std::uint8_t> label = by_path(labels);
    const std::size_t n = label.size();
    std::array<double, 3> sum{}, count{};  // within the first group, between groups, within the second
    std::array<double, 2> size{};
    for (std::size_t i = 0; i < n; ++i) {
      size[label[i]] += 1;
      for (std::size_t k = i + 1; k < n; ++k) {
        const std::size_t which = label[i] + label[k];
        sum[which] += terms_[i * n + k];
        count[which] += is_known_[i * n + k];
      }
    }
    for (const double one : count)
      if (one == 0) return 0.0;
    // Averages over all pairs including each path with itself, estimated from the available ones.
    return 2 * sum[1] / count[1] - (1 - 1 / size[0]) * sum[0] / count[0] -
           (1 - 1 / size[1]) * sum[2] / count[2];
  }

  std::vector<std::uint8_t> by_path(const Labels& labels) const {
    std::vector<std::uint8_t> label;
    for (const std::size_t unit : unit_) label.push_back(labels[unit]);
    return label;
  }

  bool are_paired_;
  std::vector<std::size_t> unit_;  ///< of each path, or pair
  std::vector<double> terms_;      ///< paths x paths
  std::vector<double> is_known_;   ///< likewise, 0 or 1
  double n_known_ = 0;
};

/// True if every assignment of labels gives both looks the same statistic: the values, or the differences of
/// pairs, of one are a linear function, or a multiple, of the other's.
bool are_same(const TwoSamples& one, const TwoSamples& other) {
  if (one.first.size() != other.first.size() || one.second.size() != other.second.size() ||
      one.first_group != other.first_group || one.second_group != other.second_group)
    return false;
  const auto all = [](const TwoSamples& samples) {
    if (samples.are_paired) {
      std::vector<double> values = samples.differences();
      values.push_back(0);
      return values;
    }
    std::vector<double> values = samples.first;
    values.insert(values.end(), samples.second.begin(), samples.second.end());
    return values;
  };
  const std::vector<double> x = all(one), y = all(other);
  const auto far = static_cast<std::size_t>(
      std::ranges::max_element(x, {}, [&](double value) { return std::abs(value - x.back()); }) - x.begin());
  if (x[far] == x.back()) return false;
  const double slope = (y[far] - y.back()) / (x[far] - x.back());
  constexpr double rounding = 1e-9;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!(std::abs(y[i] - y.back() - slope * (x[i] - x.back())) <= rounding * std::abs(y[far] - y.back())))
      return false;
  return slope != 0;
}

bool varies(const TwoSamples& samples) {
  const auto differs = [&](double value) { return value != samples.first.front(); };
  if (samples.are_paired) return samples.first != samples.second;
  return std::ranges::any_of(samples.first, differs) || std::ranges::any_of(samples.second, differs);
}

}  // namespace

double permutation_probability(const TwoSamples& samples) {
  if (samples.first.empty() || samples.second.empty()) return 1;
  const Units units = units_of(samples);
  return share_as_large(units.design(), MeanStatistic(samples, units));
}

double least_probability(const TwoSamples& samples) {
  return least_probability(units_of(samples).design());
}

EnergyDistance energy_distance(const TwoGroupsOfPaths& paths) {
  if (paths.first.size() < 2 || paths.second.size() < 2) return {};
  const Units units = units_of(paths);
  const EnergyStatistic statistic(paths, units);
  if (paths.are_paired && !statistic.is_defined()) return {};
  return {statistic(observed_labels(units.design())), share_as_large(units.design(), std::cref(statistic))};
}

JointTest joint_test(std::span<const TwoSamples> looks, std::span<const TwoGroupsOfPaths> paths) {
  Units units;
  for (const TwoSamples& look : looks) units.add(look);
  for (const TwoGroupsOfPaths& one : paths) units.add(one);
  const std::size_t n = looks.size() + paths.size();
  JointTest found{std::vector<double>(n, not_a_number), std::vector<int>(n, -1)};
  std::vector<Look> counted;
  std::vector<std::size_t> place;
  const auto can_be_significant = [&](const auto& lists) {
    const Design design = units_of(lists).design();
    found.least = std::fmin(found.least, least_probability(design));
    // Looks too small for any labels are left out, so that the others lose nothing (Tarone 1990, Biometrics
    // 46, 515); the observed labels must not decide it, since they are permuted.
    const std::size_t half = design.n_units() / 2;
    const bool can =
        least_probability(design.are_paired ? design : Design{half, design.n_units() - half}) <= significant;
    found.n_too_small += can ? 0 : 1;
    return can;
  };
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (looks[i].first.empty() || looks[i].second.empty() || !varies(looks[i])) continue;
    for (std::size_t k = 0; k < i && found.same_as[i] < 0; ++k)
      if (found.same_as[k] < 0 && are_same(looks[k], looks[i])) found.same_as[i] = static_cast<int>(k);
    if (found.same_as[i] >= 0 || !can_be_significant(looks[i])) continue;
    counted.push_back({MeanStatistic(looks[i], units)});
    place.push_back(i);
  }
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (paths[i].first.size() < 2 || paths[i].second.size() < 2) continue;
    const auto statistic = std::make_shared<EnergyStatistic>(paths[i], units);
    if (!statistic->is_defined() || !can_be_significant(paths[i])) continue;
    counted.push_back({[statistic](const Labels& labels) { return (*statistic)(labels); }, true});
    place.push_back(looks.size() + i);
  }
  found.n_looks = static_cast<int>(counted.size());
  const std::vector<double> adjusted = step_down_max_t(units.design(), counted);
  for (std::size_t k = 0; k < place.size(); ++k) found.adjusted[place[k]] = adjusted[k];
  for (std::size_t i = 0; i < n; ++i)
    if (found.same_as[i] >= 0) found.adjusted[i] = found.adjusted[index(found.same_as[i])];
  return found;
}

}  // namespace crackle::analysis
