// SPDX-License-Identifier: GPL-3.0-or-later
#include "input/copula.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace crackle::input {

std::vector<std::vector<double>> copula(const Study& study) {
  const std::size_t n = study.random.size();
  std::vector<std::vector<double>> matrix(n, std::vector<double>(n, 0));
  for (std::size_t i = 0; i < n; ++i) matrix[i][i] = 1;
  const auto number_of = [&](const std::string& key) {
    const auto found = std::ranges::find(study.random, key, &RandomInput::key);
    return static_cast<std::size_t>(found - study.random.begin());
  };
  for (const auto& [between, rank] : study.correlations) {
    const std::size_t i = number_of(between[0]), k = number_of(between[1]);
    matrix[i][k] = matrix[k][i] = 2 * std::sin(std::numbers::pi * rank / 6);
  }
  return matrix;
}

std::vector<std::vector<double>> copula_factor(const Study& study) {
  constexpr double least_pivot = 1e-10;
  std::vector<std::vector<double>> factor = copula(study);
  for (std::size_t i = 0; i < factor.size(); ++i)
    for (std::size_t k = 0; k < factor.size(); ++k) {
      if (k > i) {
        factor[i][k] = 0;
        continue;
      }
      for (std::size_t j = 0; j < k; ++j) factor[i][k] -= factor[i][j] * factor[k][j];
      if (k == i && factor[i][i] < least_pivot) return {};
      factor[i][k] = k == i ? std::sqrt(factor[i][i]) : factor[i][k] / factor[k][k];
    }
  return factor;
}

}  // namespace crackle::input
