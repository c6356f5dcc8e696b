// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/experiment/distances.h"

#include "crackle/common/real.h"

#include <algorithm>
#include <cmath>

namespace crackle::experiment {

std::vector<double> Distances::means() const {
  std::vector<double> means(n_, 0);
  for (std::size_t i = 0; i < n_; ++i) {
    for (std::size_t k = 0; k < n_; ++k) means[i] += (*this)(i, k);
    if (n_ > 1) means[i] /= static_cast<double>(n_ - 1);
  }
  return means;
}

double largest_difference(const ValueTable& table) {
  double largest = 0;
  for (std::size_t c = 0; c < table.n_columns; ++c) {
    double low = infinity, high = -infinity;
    for (std::size_t i = 0; i < table.n_rows(); ++i) {
      const double value = table.row(i)[c];
      if (std::isnan(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
    if (high > low) largest = std::max(largest, high - low);
  }
  return largest > 0 ? largest : 1;
}

double distance(std::span<const double> one, std::span<const double> other, double missing) {
  double sum = 0;
  for (std::size_t c = 0; c < one.size(); ++c) {
    const bool has_one = !std::isnan(one[c]), has_other = !std::isnan(other[c]);
    if (!has_one && !has_other) continue;
    const double difference = has_one && has_other ? one[c] - other[c] : missing;
    sum += difference * difference;
  }
  return std::sqrt(sum / static_cast<double>(one.size()));
}

Distances distances_of(const ValueTable& table) {
  const double missing = largest_difference(table);
  Distances distances(table.n_rows());
  for (std::size_t i = 0; i < table.n_rows(); ++i)
    for (std::size_t k = i + 1; k < table.n_rows(); ++k)
      distances.set(i, k, distance(table.row(i), table.row(k), missing));
  return distances;
}

Distances joint_distances(std::span<const Distances> distances) {
  const std::size_t n = distances.front().size();
  std::vector<double> squares(n * n, 0);
  for (const Distances& each : distances) {
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < n; ++k) sum += each(i, k) * each(i, k);
    if (sum == 0) continue;
    const double factor = static_cast<double>(n * (n - 1)) / sum;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < n; ++k) squares[i * n + k] += factor * each(i, k) * each(i, k);
  }
  Distances joint(n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = i + 1; k < n; ++k)
      joint.set(i, k, std::sqrt(squares[i * n + k] / static_cast<double>(distances.size())));
  return joint;
}

}  // namespace crackle::experiment
