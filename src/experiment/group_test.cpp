// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/experiment/group_test.h"

#include "crackle/common/random.h"

#include <boost/math/distributions/fisher_f.hpp>

#include <boost/math/distributions/students_t.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace crackle::experiment {

namespace {

/// The difference of the means, second minus first, with Welch's interval.
analysis::BoundedMean welch(const std::vector<double>& first, const std::vector<double>& second,
                            double confidence) {
  analysis::Moments a, b;
  for (const double value : first) a.add(value);
  for (const double value : second) b.add(value);
  const auto square_error = [](const analysis::Moments& one) {
    return std::pow(one.standard_deviation(), 2) / one.count();
  };
  const double x = square_error(a), y = square_error(b), difference = b.mean() - a.mean();
  if (std::isnan(x + y)) return {difference};
  if (x + y <= 0) return {difference, not_a_number, not_a_number, true};
  const double degrees = std::pow(x + y, 2) / (x * x / (a.count() - 1.0) + y * y / (b.count() - 1.0));
  const double half_width =
      boost::math::quantile(boost::math::students_t(degrees), (1 + confidence) / 2) * std::sqrt(x + y);
  return {difference, difference - half_width, difference + half_width};
}

constexpr double level = 0.05;
/// Permutations of each pseudo-experiment; 0.05 is a multiple of 1 / (n + 1).
constexpr std::int64_t n_permutations_of_trial = 199;
/// Columns count that at least this share of the samples reaches.
constexpr double counting_share = 0.9;

using Rows = std::vector<std::size_t>;

/// Statistics of a group of rows against the others.
class Statistics {
public:
  explicit Statistics(const Distances& distances) : distances_(distances) {
    const std::size_t n = distances.size();
    for (const double mean : distances.means()) {
      sums_.push_back(mean * static_cast<double>(n - 1));
      total_ += sums_.back();
    }
    Rows order(n);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return sums_[i]; });
    ranks_.resize(n);
    for (std::size_t first = 0; first < n;) {
      std::size_t end = first + 1;
      while (end < n && sums_[order[end]] <= sums_[order[first]] * (1 + rounding)) ++end;
      for (std::size_t k = first; k < end; ++k)
        ranks_[order[k]] = (static_cast<double>(first) + static_cast<double>(end) + 1) / 2;
      first = end;
    }
  }

  double energy(const Rows& group) const {
    double within = 0, of_group = 0;
    for (const std::size_t i : group) {
      of_group += sums_[i];
      for (const std::size_t k : group) within += distances_(i, k);
    }
    const auto m = static_cast<double>(group.size());
    const auto n = static_cast<double>(distances_.size()) - m;
    const double between = of_group - within;
    return 2 * between / (m * n) - within / (m * m) - (total_ - 2 * between - within) / (n * n);
  }

  double rank_sum(const Rows& group) const {
    double sum = 0;
    for (const std::size_t i : group) sum += ranks_[i];
    return sum;
  }

private:
  const Distances& distances_;
  std::vector<double> sums_;  ///< of each row's distances
  std::vector<double> ranks_;
  double total_ = 0;
};

double n_ways(std::size_t n, std::size_t m) {
  double ways = 1;
  for (std::size_t i = 1; i <= m && ways <= 1e12; ++i)
    ways *= static_cast<double>(n - m + i) / static_cast<double>(i);
  return std::round(ways);
}

/// The next choice of rows out of n in lexicographic order; false after the last one.
bool next_choice(Rows& rows, std::size_t n) {
  for (std::size_t k = rows.size(); k-- > 0;) {
    if (rows[k] == n - rows.size() + k) continue;
    ++rows[k];
    for (std::size_t j = k + 1; j < rows.size(); ++j) rows[j] = rows[j - 1] + 1;
    return true;
  }
  return false;
}

/// m of n rows at random: the beginning of a shuffled list.
Rows random_choice(RandomStream& stream, Rows& all, std::size_t m) {
  for (std::size_t i = 0; i < m; ++i) {
    const auto rest = static_cast<double>(all.size() - i);
    std::swap(all[i], all[i + static_cast<std::size_t>(stream.uniform() * rest)]);
  }
  return {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(m)};
}

Rows first_rows(std::size_t n) {
  Rows rows(n);
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  return rows;
}

double square(double value) {
  return value * value;
}

/// Mean over the columns of each row; those without any value are left out.
std::vector<double> column_means(const ValueTable& table) {
  std::vector<double> means;
  for (std::size_t c = 0; c < table.n_columns; ++c) {
    double sum = 0, n = 0;
    for (std::size_t i = 0; i < table.n_rows(); ++i) {
      if (std::isnan(table.row(i)[c])) continue;
      sum += table.row(i)[c];
      n += 1;
    }
    means.push_back(n > 0 ? sum / n : 0);
  }
  return means;
}

/// Variance averaged over the columns.
double mean_variance(const ValueTable& table) {
  const std::vector<double> means = column_means(table);
  double total = 0, n_columns = 0;
  for (std::size_t c = 0; c < table.n_columns; ++c) {
    double sum = 0, n = 0;
    for (std::size_t i = 0; i < table.n_rows(); ++i) {
      if (std::isnan(table.row(i)[c])) continue;
      sum += square(table.row(i)[c] - means[c]);
      n += 1;
    }
    if (n < 2) continue;
    total += sum / (n - 1);
    n_columns += 1;
  }
  return n_columns > 0 ? total / n_columns : not_a_number;
}

/// Box's degrees of freedom for one row: tr^2 S / tr S^2, by the products of the rows.
double box_degrees(const ValueTable& table) {
  const std::vector<double> means = column_means(table);
  double trace = 0, square_trace = 0;
  for (std::size_t i = 0; i < table.n_rows(); ++i) {
    for (std::size_t k = 0; k < table.n_rows(); ++k) {
      double product = 0;
      for (std::size_t c = 0; c < table.n_columns; ++c)
        product += (table.row(i)[c] - means[c]) * (table.row(k)[c] - means[c]);
      square_trace += square(product);
      if (i == k) trace += product;
    }
  }
  return square_trace > 0 ? square(trace) / square_trace : 1;
}

/// The distances within one table of rows of which the first ones are changed.
Distances distances_in_trial(const ValueTable& rows, const Distances& known, const Rows& order,
                             std::size_t n_changed, double missing) {
  Distances distances(rows.n_rows());
  for (std::size_t i = 0; i < rows.n_rows(); ++i)
    for (std::size_t k = i + 1; k < rows.n_rows(); ++k)
      distances.set(i, k,
                    i < n_changed ? distance(rows.row(i), rows.row(k), missing) : known(order[i], order[k]));
  return distances;
}

}  // namespace

double GroupTest::p_value() const {
  return std::min(1.0, 2 * std::min(energy_p_value, depth_p_value));
}

GroupTest group_test(const Distances& distances, std::size_t n_experiments, std::int64_t n_random) {
  const Statistics statistics(distances);
  Rows group = first_rows(n_experiments);
  GroupTest test;
  test.energy = statistics.energy(group);
  const double energy = test.energy - rounding * std::abs(test.energy);
  const double rank_sum = statistics.rank_sum(group) * (1 - rounding);
  std::int64_t n_energy = 0, n_rank_sum = 0;
  const auto count = [&](const Rows& rows) {
    ++test.n_permutations;
    n_energy += statistics.energy(rows) >= energy ? 1 : 0;
    n_rank_sum += statistics.rank_sum(rows) >= rank_sum ? 1 : 0;
  };
  test.are_all = n_ways(distances.size(), n_experiments) <= max_exact_permutations;
  if (test.are_all) {
    do count(group);
    while (next_choice(group, distances.size()));
  } else {
    RandomStream stream(0, 0, "match: permutations");
    Rows all = first_rows(distances.size());
    count(group);
    for (std::int64_t k = 0; k < n_random; ++k) count(random_choice(stream, all, n_experiments));
  }
  test.energy_p_value = static_cast<double>(n_energy) / static_cast<double>(test.n_permutations);
  test.depth_p_value = static_cast<double>(n_rank_sum) / static_cast<double>(test.n_permutations);
  return test;
}

Power power(const ValueTable& samples, std::size_t n_experiments, int n_trials) {
  Power found;
  const std::size_t n = samples.n_rows();
  const double deviation = std::sqrt(mean_variance(samples));
  if (n < n_experiments + 2 || !(deviation > 0)) return found;
  found = {0, 0, n_trials};
  const Distances known = distances_of(samples);
  const double missing = largest_difference(samples);
  const std::vector<double> means = column_means(samples);
  RandomStream stream(0, 0, "match: pseudo-experiments");
  Rows order = first_rows(n);
  for (int trial = 0; trial < n_trials; ++trial) {
    random_choice(stream, order, n_experiments);
    for (double* share : {&found.of_shift, &found.of_scatter}) {
      ValueTable rows{samples.n_columns, {}};
      for (const std::size_t i : order) rows.add(samples.row(i));
      for (std::size_t i = 0; i < n_experiments; ++i)
        for (std::size_t c = 0; c < rows.n_columns; ++c)
          rows.row(i)[c] += share == &found.of_shift ? deviation : rows.row(i)[c] - means[c];
      const GroupTest test = group_test(distances_in_trial(rows, known, order, n_experiments, missing),
                                        n_experiments, n_permutations_of_trial);
      if (test.p_value() <= level) *share += 1.0 / n_trials;
    }
  }
  return found;
}

namespace {

/// Columns that all experiments and nearly all samples reach.
Rows counting_columns(const ValueTable& experiments, const ValueTable& samples) {
  Rows columns;
  for (std::size_t c = 0; c < samples.n_columns; ++c) {
    const auto n_arrived = [c](const ValueTable& table) {
      std::size_t n = 0;
      for (std::size_t i = 0; i < table.n_rows(); ++i) n += std::isnan(table.row(i)[c]) ? 0 : 1;
      return n;
    };
    if (n_arrived(experiments) == experiments.n_rows() &&
        static_cast<double>(n_arrived(samples)) >= counting_share * static_cast<double>(samples.n_rows()))
      columns.push_back(c);
  }
  return columns;
}

/// The rows that have a value in all of these columns.
ValueTable complete_rows(const ValueTable& table, const Rows& columns) {
  ValueTable complete{columns.size(), {}};
  for (std::size_t i = 0; i < table.n_rows(); ++i) {
    std::vector<double> row;
    for (const std::size_t c : columns) row.push_back(table.row(i)[c]);
    if (std::ranges::none_of(row, [](double value) { return std::isnan(value); })) complete.add(row);
  }
  return complete;
}

/// The mean of each row.
std::vector<double> row_means(const ValueTable& table) {
  std::vector<double> means;
  for (std::size_t i = 0; i < table.n_rows(); ++i) {
    const auto row = table.row(i);
    means.push_back(std::accumulate(row.begin(), row.end(), 0.0) / static_cast<double>(row.size()));
  }
  return means;
}

}  // namespace

Scatter scatter(const ValueTable& all_experiments, const ValueTable& all_samples, double error,
                double confidence) {
  const Rows columns = counting_columns(all_experiments, all_samples);
  Scatter found{.n_columns = columns.size()};
  if (columns.empty()) return found;
  const ValueTable experiments = complete_rows(all_experiments, columns);
  const ValueTable samples = complete_rows(all_samples, columns);
  found.n_experiments = experiments.n_rows();
  found.n_samples = samples.n_rows();
  if (found.n_experiments < 2 || found.n_samples < 2) return found;
  found.shift =
      welch(row_means(samples), row_means(experiments), confidence);
  const double of_samples = mean_variance(samples), of_error = error * error;
  if (!(of_samples > 0)) return found;
  found.degrees = box_degrees(samples);
  const boost::math::fisher_f f((static_cast<double>(found.n_experiments) - 1) * found.degrees,
                                (static_cast<double>(found.n_samples) - 1) * found.degrees);
  const double variance = mean_variance(experiments);
  const auto ratio = [&](double factor) {
    return std::sqrt(std::max(0.0, factor * variance - of_error) / of_samples);
  };
  const double tail = (1 - confidence) / 2;
  found.ratio = {ratio(1), ratio(1 / boost::math::quantile(f, 1 - tail)),
                 ratio(1 / boost::math::quantile(f, tail))};
  return found;
}

}  // namespace crackle::experiment
