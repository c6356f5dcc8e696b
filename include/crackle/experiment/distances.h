// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace crackle::experiment {

/// Statistics that differ by less, relatively, are equal up to rounding.
inline constexpr double rounding = 1e-9;

/// Rows of equally many values; NaN: a crack did not get there. A row stands for an experiment or a sample.
struct ValueTable {
  std::size_t n_columns = 0;
  std::vector<double> values;  ///< row-major

  std::size_t n_rows() const { return n_columns == 0 ? 0 : values.size() / n_columns; }
  std::span<const double> row(std::size_t i) const {
    return std::span(values).subspan(i * n_columns, n_columns);
  }
  std::span<double> row(std::size_t i) { return std::span(values).subspan(i * n_columns, n_columns); }
  void add(std::span<const double> row) { values.insert(values.end(), row.begin(), row.end()); }
};

/// The distance of each two rows.
class Distances {
public:
  explicit Distances(std::size_t n) : n_(n), values_(n * n, 0) {}
  std::size_t size() const { return n_; }
  double operator()(std::size_t i, std::size_t k) const { return values_[i * n_ + k]; }
  void set(std::size_t i, std::size_t k, double value) { values_[i * n_ + k] = values_[k * n_ + i] = value; }

  /// Mean distance of each row to all others.
  std::vector<double> means() const;

private:
  std::size_t n_;
  std::vector<double> values_;
};

/// The largest difference of two values in the same column; 1 if there is none. What lacks a value is as far
/// as that from what has one.
double largest_difference(const ValueTable& table);

/// Root mean square difference of two rows over the columns; where one has a value and the other has not, the
/// difference is `missing`.
double distance(std::span<const double> one, std::span<const double> other, double missing);

/// The distances of all rows, with their largest_difference for `missing`.
Distances distances_of(const ValueTable& table);

/// Several distances of the same rows as one: the root mean square of each divided by its own root mean
/// square over all pairs, so that all count alike.
Distances joint_distances(std::span<const Distances> distances);

}  // namespace crackle::experiment
