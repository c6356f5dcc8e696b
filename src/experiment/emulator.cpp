// SPDX-License-Identifier: GPL-3.0-or-later
#include "emulator.h"

#include "crackle/common/index.h"
#include "crackle/uncertainty/polynomials.h"
#include "crackle/uncertainty/random_inputs.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace crackle::experiment {

namespace {

constexpr std::size_t n_nodes = 2049;
constexpr double node_spacing = 2 * most_deviations / (n_nodes - 1);

double variable_at(std::size_t node) {
  return -most_deviations + node_spacing * static_cast<double>(node);
}

double interpolated(const std::vector<double>& nodes, double variable) {
  const double at =
      (std::clamp(variable, -most_deviations, most_deviations) + most_deviations) / node_spacing;
  const auto left = std::min(static_cast<std::size_t>(at), n_nodes - 2);
  const double share = at - static_cast<double>(left);
  return (1 - share) * nodes[left] + share * nodes[left + 1];
}

/// The terms up to a number at each sample.
Eigen::MatrixXd rows_of(const analysis::ChaosBasis& basis, const std::vector<std::size_t>& draw,
                        Eigen::Index n_terms) {
  Eigen::MatrixXd rows(std::ssize(draw), n_terms);
  for (std::size_t i = 0; i < draw.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) =
        basis.table().row(static_cast<Eigen::Index>(draw[i])).head(n_terms);
  return rows;
}

/// The sums of rows over each draw.
Eigen::MatrixXd sums_by_draw(const Eigen::MatrixXd& rows, const EmulatedValues& values) {
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(values.n_draws()), rows.cols());
  Eigen::Index k = -1;
  for (std::size_t i = 0; i < values.draw.size(); ++i) {
    k += i == 0 || values.draw[i] != values.draw[i - 1];
    sums.row(k) += rows.row(static_cast<Eigen::Index>(i));
  }
  return sums;
}

}  // namespace

InputTable::InputTable(const std::vector<input::RandomInput>& random, int highest_degree) {
  for (const input::RandomInput& each : random) {
    auto& values = value_.emplace_back();
    for (std::size_t node = 0; node < n_nodes; ++node)
      values.push_back(uncertainty::quantile(each, std::erfc(-variable_at(node) / std::numbers::sqrt2) / 2));
    polynomial_.push_back(uncertainty::orthonormal_polynomials(each, values, highest_degree));
  }
}

double InputTable::value(std::size_t input, double variable) const {
  return interpolated(value_[input], variable);
}

double InputTable::polynomial(std::size_t input, int degree, double variable) const {
  return interpolated(polynomial_[input][index(degree)], variable);
}

double InputTable::moment(std::size_t input, double about, int order) const {
  double sum = 0;
  for (std::size_t node = 0; node < n_nodes; ++node)
    sum += std::exp(-std::pow(variable_at(node), 2) / 2) * std::pow(value_[input][node] - about, order);
  return sum * node_spacing / std::sqrt(2 * std::numbers::pi);
}

double InputTable::mean(std::size_t input) const {
  return moment(input, 0, 1);
}

double InputTable::standard_deviation(std::size_t input) const {
  return std::sqrt(moment(input, mean(input), 2));
}

EmulatorBasis::EmulatorBasis(const std::vector<input::RandomInput>& random,
                             const std::vector<std::vector<double>>& draws)
    : basis(random, draws), table(random, basis.highest_degree()) {}

Eigen::VectorXd EmulatorBasis::terms(const Eigen::VectorXd& variables, Eigen::Index n_terms) const {
  const int n_degrees = basis.highest_degree() + 1;
  const auto n_inputs = static_cast<Eigen::Index>(table.n_inputs());
  Eigen::MatrixXd polynomials(n_degrees, n_inputs);
  for (Eigen::Index k = 0; k < n_inputs; ++k)
    for (int degree = 0; degree < n_degrees; ++degree)
      polynomials(degree, k) = table.polynomial(index(k), degree, variables[k]);
  Eigen::VectorXd products = Eigen::VectorXd::Ones(n_terms);
  for (Eigen::Index t = 0; t < n_terms; ++t)
    for (Eigen::Index k = 0; k < n_inputs; ++k)
      products[t] *= polynomials(basis.degrees()[index(t)][index(k)], k);
  return products;
}

std::size_t EmulatedValues::n_draws() const {
  return analysis::DrawnValues{draw, {}}.n_draws();
}

EmulatedValues EmulatedValues::without(std::size_t left_out) const {
  EmulatedValues rest;
  std::vector<Eigen::Index> kept;
  for (std::size_t i = 0; i < draw.size(); ++i) {
    if (draw[i] == left_out) continue;
    rest.draw.push_back(draw[i]);
    kept.push_back(static_cast<Eigen::Index>(i));
  }
  rest.value = value(kept, Eigen::all);
  return rest;
}

Emulator::Emulator(std::shared_ptr<const EmulatorBasis> basis, const EmulatedValues& values,
                   std::vector<int> degree, std::vector<double> predicted)
    : basis_(std::move(basis)), degree_(std::move(degree)), predicted_(std::move(predicted)) {
  const Eigen::Index n = values.value.rows(), n_columns = values.value.cols();
  Eigen::Index most = 1;
  for (Eigen::Index c = 0; c < n_columns; ++c) most = std::max(most, n_terms(c));
  const Eigen::HouseholderQR<Eigen::MatrixXd> factors(rows_of(basis_->basis, values.draw, most));
  triangle_ = factors.matrixQR().topRows(most).triangularView<Eigen::Upper>();
  // The first columns of Q span the terms up to each degree.
  coefficient_ = (factors.householderQ().transpose() * values.value).topRows(most);
  for (Eigen::Index c = 0; c < n_columns; ++c) coefficient_.col(c).tail(most - n_terms(c)).setZero();

  const Eigen::MatrixXd residual = residuals(values);
  const Eigen::MatrixXd sums = sums_by_draw(residual, values);
  const auto n_draws = static_cast<double>(values.n_draws());
  Eigen::VectorXd weight(n_columns), weight_of_sums(n_columns);
  for (Eigen::Index c = 0; c < n_columns; ++c) {
    const auto terms = static_cast<double>(n_terms(c));
    weight[c] = 1 / std::sqrt(static_cast<double>(n) - terms);
    weight_of_sums[c] = 1 / std::sqrt(static_cast<double>(n) * (1 - terms / n_draws));
  }
  scatter_ = weight.asDiagonal() * (residual.transpose() * residual) * weight.asDiagonal();
  shared_scatter_ = weight_of_sums.asDiagonal() * (sums.transpose() * sums) * weight_of_sums.asDiagonal();
  variance_ = (values.value.rowwise() - values.value.colwise().mean()).colwise().squaredNorm().transpose() /
              static_cast<double>(n - 1);
  degrees_of_freedom_ = n_draws - static_cast<double>(most);
  mean_leverage_ = static_cast<double>(most) / static_cast<double>(n);
}

Emulator::Emulator(std::shared_ptr<const EmulatorBasis> basis, const EmulatedValues& values)
    : Emulator([&] {
        std::vector<int> degree;
        std::vector<double> predicted;
        for (Eigen::Index c = 0; c < values.value.cols(); ++c) {
          const auto chosen = choose_degree(basis->basis, {values.draw, values.value.col(c)});
          degree.push_back(chosen.degree);
          predicted.push_back(chosen.predicted);
        }
        return Emulator(basis, values, std::move(degree), std::move(predicted));
      }()) {}

Emulator Emulator::refitted(const EmulatedValues& values, const std::vector<Eigen::Index>& columns) const {
  EmulatedValues used{values.draw, values.value(Eigen::all, columns)};
  std::vector<int> degree;
  std::vector<double> predicted;
  for (const Eigen::Index c : columns) {
    degree.push_back(degree_[index(c)]);
    predicted.push_back(predicted_[index(c)]);
  }
  return Emulator(basis_, used, std::move(degree), std::move(predicted));
}

Eigen::Index Emulator::n_terms(Eigen::Index component) const {
  return basis_->basis.n_terms(degree_[index(component)]);
}

Eigen::MatrixXd Emulator::residuals(const EmulatedValues& values) const {
  const Eigen::MatrixXd rows = rows_of(basis_->basis, values.draw, triangle_.cols());
  return values.value - rows * triangle_.triangularView<Eigen::Upper>().solve(coefficient_);
}

Emulator::Prediction Emulator::predict(const Eigen::VectorXd& variables) const {
  const Eigen::VectorXd q =
      triangle_.transpose().triangularView<Eigen::Lower>().solve(basis_->terms(variables, triangle_.cols()));
  Prediction found{coefficient_.transpose() * q, Eigen::VectorXd(n_components())};
  for (Eigen::Index c = 0; c < n_components(); ++c) found.leverage[c] = q.head(n_terms(c)).squaredNorm();
  return found;
}

}  // namespace crackle::experiment
