// SPDX-License-Identifier: GPL-3.0-or-later
#include "chaos_expansion.h"

#include "common/index.h"
#include "common/real.h"
#include "uncertainty/polynomials.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace crackle::analysis {

namespace {

constexpr int most_degrees = 12;
constexpr std::size_t most_terms = 200;
/// Minimum number of draws per term; a fit with fewer follows the scatter.
constexpr std::size_t draws_per_term = 2;

/// Enumerates all distributions of `degree` over the inputs from number `input` on.
void add_degrees(std::size_t input, int degree, std::vector<int>& term,
                 std::vector<std::vector<int>>& terms) {
  if (input + 1 == term.size()) {
    term[input] = degree;
    terms.push_back(term);
    return;
  }
  for (int own = degree; own >= 0; --own) {
    term[input] = own;
    add_degrees(input + 1, degree - own, term, terms);
  }
}

Eigen::MatrixXd rows_of(const Eigen::MatrixXd& table, const std::vector<std::size_t>& draws,
                        Eigen::Index n_columns) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(draws.size()), n_columns);
  for (std::size_t i = 0; i < draws.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) = table.row(static_cast<Eigen::Index>(draws[i])).head(n_columns);
  return rows;
}

}  // namespace

ChaosBasis::ChaosBasis(const std::vector<input::RandomInput>& random,
                       const std::vector<std::vector<double>>& values) {
  const std::size_t n_draws = values.size(), n_inputs = random.size();
  for (int degree = 0; degree <= most_degrees; ++degree) {
    std::vector<std::vector<int>> terms;
    std::vector<int> term(n_inputs);
    add_degrees(0, degree, term, terms);
    std::erase_if(terms, [&](const std::vector<int>& one) {
      for (std::size_t k = 0; k < n_inputs; ++k)
        if (one[k] > uncertainty::most_degree(random[k])) return true;
      return false;
    });
    const std::size_t n = degrees_.size() + terms.size();
    if (degree > 0 && (n > most_terms || n * draws_per_term > n_draws)) break;
    degrees_.insert(degrees_.end(), terms.begin(), terms.end());
    n_terms_.push_back(static_cast<Eigen::Index>(n));
  }
  table_ = Eigen::MatrixXd::Ones(static_cast<Eigen::Index>(n_draws), n_terms_.back());
  for (std::size_t k = 0; k < n_inputs; ++k) {
    std::vector<double> column;
    for (const auto& draw : values) column.push_back(draw[k]);
    const auto polynomials = uncertainty::orthonormal_polynomials(random[k], column, highest_degree());
    for (std::size_t t = 0; t < degrees_.size(); ++t) {
      const auto& factor = polynomials[index(degrees_[t][k])];
      table_.col(static_cast<Eigen::Index>(t)).array() *=
          Eigen::Map<const Eigen::ArrayXd>(factor.data(), static_cast<Eigen::Index>(n_draws));
    }
  }
}

std::size_t DrawnValues::n_draws() const {
  std::size_t n = 0;
  for (std::size_t i = 0; i < draw.size(); ++i) n += i == 0 || draw[i] != draw[i - 1];
  return n;
}

ChosenDegree choose_degree(const ChaosBasis& basis, const DrawnValues& values) {
  const Eigen::Index n = values.value.size();
  const double variation = (values.value.array() - values.value.mean()).square().sum();
  const Eigen::MatrixXd rows = rows_of(basis.table(), values.draw, basis.table().cols());
  // The first columns of Q span the terms up to each degree.
  const Eigen::HouseholderQR<Eigen::MatrixXd> factors(rows);
  const Eigen::MatrixXd q = factors.householderQ() * Eigen::MatrixXd::Identity(n, rows.cols());
  ChosenDegree best{0, -infinity};
  // Some draws of the basis may have no value.
  const std::size_t n_draws = values.n_draws();
  for (int degree = 0; degree <= basis.highest_degree(); ++degree) {
    if (degree > 0 && static_cast<std::size_t>(basis.n_terms(degree)) * draws_per_term > n_draws) break;
    const auto span = q.leftCols(basis.n_terms(degree));
    const Eigen::VectorXd residual = values.value - span * (span.transpose() * values.value);
    double error = 0;
    for (Eigen::Index begin = 0, end = 0; begin < n; begin = end) {
      while (end < n && values.draw[index(end)] == values.draw[index(begin)]) ++end;
      const auto block = span.middleRows(begin, end - begin);
      const Eigen::MatrixXd left_out =
          Eigen::MatrixXd::Identity(end - begin, end - begin) - block * block.transpose();
      error += left_out.fullPivLu().solve(residual.segment(begin, end - begin)).squaredNorm();
    }
    const double predicted = 1 - error / variation;
    if (predicted > best.predicted) best = {degree, predicted};
  }
  // What predicts nothing explains nothing.
  if (!(best.predicted > 0)) best.degree = 0;
  return best;
}

Eigen::VectorXd fitted_values(const ChaosBasis& basis, const DrawnValues& values, int degree) {
  const Eigen::MatrixXd rows = rows_of(basis.table(), values.draw, basis.n_terms(degree));
  return rows * rows.householderQr().solve(values.value);
}

SobolIndices sobol_indices(const ChaosBasis& basis, const DrawnValues& values, int degree,
                           const Eigen::VectorXd& weight, bool corrects) {
  const std::size_t n_inputs = basis.degrees().front().size();
  SobolIndices indices{std::vector<double>(n_inputs, 0), std::vector<double>(n_inputs, 0)};
  const Eigen::Index n_terms = basis.n_terms(degree);
  const Eigen::MatrixXd rows = rows_of(basis.table(), values.draw, n_terms);
  const double n = weight.sum();
  const Eigen::MatrixXd normal = rows.transpose() * weight.asDiagonal() * rows;
  const Eigen::LDLT<Eigen::MatrixXd> factors(normal);
  const double mean = weight.dot(values.value) / n;
  const double variance = (weight.array() * (values.value.array() - mean).square()).sum() / (n - 1);
  if (!factors.isPositive() || factors.rcond() < 1e-12 || variance <= 0) {
    indices.first.assign(n_inputs, not_a_number);
    indices.total.assign(n_inputs, not_a_number);
    return indices;
  }
  const Eigen::VectorXd coefficient =
      factors.solve(rows.transpose() * (weight.array() * values.value.array()).matrix());
  const Eigen::VectorXd residual = values.value - rows * coefficient;
  const double scatter = (weight.array() * residual.array().square()).sum() /
                         std::max(1.0, n - static_cast<double>(corrects ? n_terms : 1));
  Eigen::VectorXd squares = coefficient.array().square();
  if (corrects) squares -= scatter * factors.solve(Eigen::MatrixXd::Identity(n_terms, n_terms)).diagonal();
  for (Eigen::Index t = 1; t < n_terms; ++t) {
    const auto& degrees = basis.degrees()[index(t)];
    const auto takes_part = [](int one) { return one > 0; };
    const bool is_alone = std::ranges::count_if(degrees, takes_part) == 1;
    for (std::size_t k = 0; k < n_inputs; ++k) {
      if (degrees[k] == 0) continue;
      indices.total[k] += squares[t];
      if (is_alone) indices.first[k] += squares[t];
    }
  }
  // Squares are variances over all draws, what is explained is a share of those that have a value.
  const double all = squares.tail(n_terms - 1).sum();
  const double explained = std::max(0.0, 1 - scatter / variance);
  for (std::size_t k = 0; k < n_inputs; ++k) {
    // Corrected, the squares of interactions may be negative.
    const double first = std::max(0.0, indices.first[k]), total = std::max(first, indices.total[k]);
    const double whole = std::max(all, total);
    indices.first[k] = whole > 0 ? explained * first / whole : 0;
    indices.total[k] = whole > 0 ? explained * total / whole : 0;
  }
  return indices;
}

}  // namespace crackle::analysis
