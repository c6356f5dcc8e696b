// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/experiment/rank_test.h"

#include <algorithm>
#include <cmath>

namespace crackle::experiment {

namespace {

/// Rank of a value in ascending values, from 1, made continuous by its distance to its neighbours: below 1
/// for the first one, and the less the farther it is from all others. Equal values share the largest rank.
double continuous_rank(const std::vector<double>& sorted, double value) {
  // Not of std::ranges, whose subranges of GCC 12 are beyond clang 14.
  const auto [first, end] = std::equal_range(sorted.begin(), sorted.end(), value);
  const auto rank = static_cast<double>(end - sorted.begin());
  if (end - first > 1 || end == sorted.end()) return rank;
  const double gap_after = *end - value;
  if (first == sorted.begin()) {
    const double rest = sorted.back() - *end;
    return rest > 0 ? std::exp(-gap_after / rest) : 0;
  }
  const double gap_before = value - *(first - 1);
  return rank - 1 + gap_before / (gap_before + gap_after);
}

/// Ranks of all rows in one column, from below or above, whichever is smaller.
std::vector<double> extreme_ranks(const ValueTable& table, std::size_t column) {
  std::vector<double> ascending, reversed;
  for (std::size_t i = 0; i < table.n_rows(); ++i)
    if (!std::isnan(table.row(i)[column])) ascending.push_back(table.row(i)[column]);
  for (const double value : ascending) reversed.push_back(-value);
  std::ranges::sort(ascending);
  std::ranges::sort(reversed);
  const auto n_missing = static_cast<double>(table.n_rows() - ascending.size());
  std::vector<double> ranks;
  for (std::size_t i = 0; i < table.n_rows(); ++i) {
    const double value = table.row(i)[column];
    ranks.push_back(std::isnan(value)
                        ? n_missing
                        : std::min(continuous_rank(ascending, value), continuous_rank(reversed, -value)));
  }
  return ranks;
}

/// For each row its least rank, rounded up, less the mean by which its ranks are below that.
std::vector<double> area_ranks(const ValueTable& table) {
  std::vector<std::vector<double>> ranks;
  for (std::size_t c = 0; c < table.n_columns; ++c) ranks.push_back(extreme_ranks(table, c));
  std::vector<double> areas;
  for (std::size_t i = 0; i < table.n_rows(); ++i) {
    double least = infinity, below = 0;
    for (const auto& of_column : ranks) least = std::min(least, of_column[i]);
    for (const auto& of_column : ranks) below += std::max(0.0, std::ceil(least) - of_column[i]);
    areas.push_back(std::ceil(least) - below / static_cast<double>(table.n_columns));
  }
  return areas;
}

}  // namespace

std::size_t samples_needed(double level) {
  return static_cast<std::size_t>(std::ceil(1 / level - rounding)) - 1;
}

double rank_p_value(const Distances& distances) {
  const std::vector<double> means = distances.means();
  const double threshold = means[0] - rounding * std::abs(means[0]);
  const auto n = std::ranges::count_if(means, [&](double mean) { return mean >= threshold; });
  return static_cast<double>(n) / static_cast<double>(means.size());
}

Envelope envelope(const ValueTable& table, double confidence) {
  const std::size_t n = table.n_rows();
  const std::vector<double> areas = area_ranks(table);
  Envelope found;
  const auto n_as_extreme = [&](std::size_t i) {
    return std::ranges::count_if(areas, [&](double other) { return other <= areas[i] + rounding; });
  };
  found.p_value = static_cast<double>(n_as_extreme(0)) / static_cast<double>(n);
  const double n_left_out = std::max(1.0, std::floor((1 - confidence) * static_cast<double>(n) + rounding));
  found.level = 1 - n_left_out / static_cast<double>(n);
  found.lower.assign(table.n_columns, not_a_number);
  found.upper = found.lower;
  std::vector<bool> all_arrive(table.n_columns, true);  // of the rows that remain
  for (std::size_t i = 0; i < n; ++i) {
    if (static_cast<double>(n_as_extreme(i)) <= n_left_out) continue;
    for (std::size_t c = 0; c < table.n_columns; ++c) {
      found.lower[c] = std::fmin(found.lower[c], table.row(i)[c]);
      found.upper[c] = std::fmax(found.upper[c], table.row(i)[c]);
      all_arrive[c] = all_arrive[c] && !std::isnan(table.row(i)[c]);
    }
  }
  const bool is_left_out = static_cast<double>(n_as_extreme(0)) <= n_left_out;
  for (std::size_t c = 0; c < table.n_columns; ++c) {
    const double value = table.row(0)[c];
    // A band that nothing reaches holds no value.
    const bool is_in =
        std::isnan(value) ? !all_arrive[c] : value >= found.lower[c] && value <= found.upper[c];
    found.is_outside.push_back(is_left_out && !is_in);
  }
  return found;
}

}  // namespace crackle::experiment
