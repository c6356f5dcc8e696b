// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibration_data.h"

#include "crackle/common/failure.h"
#include "crackle/common/index.h"
#include "crackle/plane/shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace crackle::experiment {

namespace {

/// Components of a path: as many as hold this share of the variance, and no more than the number.
constexpr double held_share = 0.99;
constexpr Eigen::Index most_components = 5;
/// A column counts if at least this share of the samples has it.
constexpr double least_share = 0.9;

using Matrix = Eigen::MatrixXd;

/// An observable with the columns that count.
struct Part {
  QuantityBlock block;
  std::vector<std::size_t> columns;
  std::vector<std::size_t> experiments, samples;  ///< that have them all; ascending
  Matrix of_experiments, of_samples, as_read;     ///< rows of these
  Matrix error;                                   ///< of reading: columns x columns
};

std::vector<std::size_t> rows_with_all(const ValueTable& table, const std::vector<std::size_t>& columns) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < table.n_rows(); ++i)
    if (std::ranges::none_of(columns, [&](std::size_t c) { return std::isnan(table.row(i)[c]); }))
      rows.push_back(i);
  return rows;
}

/// Columns that all experiments have, and enough of the samples.
std::vector<std::size_t> usual_columns(const Observable& observable, std::size_t n_samples) {
  std::vector<std::size_t> columns;
  for (std::size_t c = 0; c < observable.of_samples.n_columns; ++c) {
    const auto n_with = std::ssize(rows_with_all(observable.of_samples, {c}));
    const bool all_experiments =
        rows_with_all(observable.of_experiments, {c}).size() == observable.of_experiments.n_rows();
    if (all_experiments && static_cast<double>(n_with) >= least_share * static_cast<double>(n_samples))
      columns.push_back(c);
  }
  return columns;
}

Matrix rows_of(const ValueTable& table, const std::vector<std::size_t>& rows,
               const std::vector<std::size_t>& columns) {
  Matrix values(std::ssize(rows), std::ssize(columns));
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t k = 0; k < columns.size(); ++k)
      values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = table.row(rows[i])[columns[k]];
  return values;
}

std::vector<std::size_t> chosen(const std::vector<std::size_t>& from, const std::vector<std::size_t>& rows) {
  std::vector<std::size_t> values;
  for (const std::size_t row : rows) values.push_back(from[row]);
  return values;
}

Part part_of(const Observable& observable, std::size_t n_samples) {
  Part part;
  part.block = {.name = name_of(observable.quantity), .unit = observable.unit};
  part.columns = usual_columns(observable, n_samples);
  if (part.columns.empty()) return part;
  const auto rows = rows_with_all(observable.of_samples, part.columns);
  const auto n = std::ssize(part.columns);
  part.experiments = observable.experiments;
  part.samples = chosen(observable.samples, rows);
  part.of_experiments =
      rows_of(observable.of_experiments, rows_with_all(observable.of_experiments, {}), part.columns);
  part.of_samples = rows_of(observable.of_samples, rows, part.columns);
  part.as_read = rows_of(observable.with_error, rows, part.columns);
  part.error = std::pow(observable.error, 2) * Matrix::Identity(n, n);
  std::vector<double> places;
  for (Eigen::Index k = 0; k < n; ++k) places.push_back(static_cast<double>(k));
  part.block.shape = smooth_shape(places);
  return part;
}

/// Paths as read may miss a station that the exact path reaches.
void fill_from_exact(Part& part) {
  for (Eigen::Index i = 0; i < part.as_read.size(); ++i)
    if (std::isnan(part.as_read(i))) part.as_read(i) = part.of_samples(i);
}

/// The mean of paths, and the directions of their largest variances.
struct PathAxes {
  Eigen::VectorXd mean, variance;  ///< ascending
  Matrix direction;                ///< a column for each
};

PathAxes axes_of(const Matrix& offsets) {
  const Eigen::VectorXd mean = offsets.colwise().mean();
  const Matrix centred = offsets.rowwise() - mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix> axes(centred.transpose() * centred);
  return {mean, axes.eigenvalues(), axes.eigenvectors()};
}

/// Least rank of what the components leave of the experiments' offsets, for all experiments together. The
/// components that a sample is ranked by are those of the others.
double shape_p_value(const PathAxes& all, const Part& part, Eigen::Index n_components) {
  const auto rest = [&](const PathAxes& axes, const Eigen::RowVectorXd& offsets) {
    const Matrix basis = axes.direction.rightCols(n_components);
    const Eigen::VectorXd centred = offsets.transpose() - axes.mean;
    return (centred - basis * (basis.transpose() * centred)).norm();
  };
  std::vector<double> of_samples;
  Matrix others = part.of_samples.bottomRows(part.of_samples.rows() - 1);
  for (Eigen::Index i = 0; i < part.as_read.rows(); ++i) {
    of_samples.push_back(rest(axes_of(others), part.as_read.row(i)));
    if (i < others.rows()) others.row(i) = part.of_samples.row(i);
  }
  double least = 1;
  for (Eigen::Index i = 0; i < part.of_experiments.rows(); ++i) {
    const double own = rest(all, part.of_experiments.row(i)) * (1 - rounding);
    const auto n_as_large = std::ranges::count_if(of_samples, [&](double each) { return each >= own; });
    least = std::min(least, static_cast<double>(n_as_large + 1) / static_cast<double>(of_samples.size() + 1));
  }
  return std::min(1.0, least * static_cast<double>(part.of_experiments.rows()));
}

/// Replaces the offsets of a path by components.
PathComponents reduce(const Observable& observable, Part& part) {
  PathComponents path{.frame = *observable.frame, .stations = part.columns, .mean = {}, .basis = {}};
  fill_from_exact(part);
  const PathAxes axes = axes_of(part.of_samples);
  path.mean = axes.mean;
  const Eigen::Index n = axes.variance.size();
  Eigen::Index kept = 1;
  while (kept < std::min(n, most_components) &&
         axes.variance.tail(kept).sum() < held_share * axes.variance.sum())
    ++kept;
  path.basis = axes.direction.rightCols(kept).rowwise().reverse();
  for (Eigen::Index k = 0; k < kept; ++k)
    if (path.basis.col(k).sum() < 0) path.basis.col(k) *= -1;
  path.shape_p_value = shape_p_value(axes, part, kept);

  std::vector<double> places{0};
  for (std::size_t k = 1; k < path.stations.size(); ++k) {
    const auto step = path.frame.place[path.stations[k]] - path.frame.place[path.stations[k - 1]];
    places.push_back(places.back() + plane::norm(step));
  }
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index k = 0; k < n; ++k) {
      const double apart = std::abs(places[index(i)] - places[index(k)]);
      const double correlation = observable.error_length > 0 ? std::exp(-apart / observable.error_length)
                                 : i == k                    ? 1.0
                                                             : 0.0;
      part.error(i, k) = std::pow(observable.error, 2) * correlation;
    }
  const auto reduced = [&](const Matrix& offsets) -> Matrix {
    return (offsets.rowwise() - path.mean.transpose()) * path.basis;
  };
  part.of_samples = reduced(part.of_samples);
  part.as_read = reduced(part.as_read);
  part.of_experiments = reduced(part.of_experiments);
  part.error = path.basis.transpose() * part.error * path.basis;
  part.block.shape = path.basis.transpose() * smooth_shape(places) * path.basis;
  return path;
}

bool varies(const Matrix& values) {
  const Eigen::RowVectorXd range = values.colwise().maxCoeff() - values.colwise().minCoeff();
  return values.rows() > 1 && range.minCoeff() > 0;
}

/// The parts that can be used; notes say why others cannot.
std::vector<Part> usable_parts(std::span<const Observable> observables, std::size_t n_samples,
                               CalibrationData& data) {
  std::vector<Part> parts;
  std::vector<const Observable*> used;
  for (const Observable& each : observables) {
    Part part = part_of(each, n_samples);
    if (part.columns.empty()) {
      data.notes.push_back(fmt::format(
          "{} is not used: an experiment or more than a tenth of the samples lack it", part.block.name));
      continue;
    }
    if (!varies(part.of_samples)) {
      data.notes.push_back(fmt::format("{} is not used: it is the same in all samples", part.block.name));
      continue;
    }
    const auto same =
        std::ranges::find_if(used, [&](const Observable* other) { return is_same_load(each, *other); });
    if (same != used.end()) {
      data.notes.push_back(fmt::format("{} is not used: in the samples it goes with {}", part.block.name,
                                       name_of((*same)->quantity)));
      continue;
    }
    used.push_back(&each);
    if (each.frame) data.path = reduce(each, part);
    parts.push_back(std::move(part));
  }
  return parts;
}

/// The samples that all parts have, with their draws.
std::vector<std::size_t> common_samples(const std::vector<Part>& parts, const ObservedSamples& samples,
                                        std::size_t n_inputs, CalibrationData& data) {
  std::vector<std::size_t> common;
  for (std::size_t i = 0; i < samples.samples.size(); ++i) {
    const bool is_whole = std::ranges::all_of(
        parts, [&](const Part& part) { return std::ranges::binary_search(part.samples, i); });
    if (is_whole && samples.samples[i].summary.inputs.size() == n_inputs)
      common.push_back(i);
    else
      data.left_out.push_back(samples.samples[i].number);
  }
  return common;
}

void set_draws(const std::vector<std::size_t>& common, const ObservedSamples& samples,
               const input::Parameters& parameters, CalibrationData& data) {
  std::optional<std::uint64_t> last;
  for (const std::size_t i : common) {
    const ObservedSample& sample = samples.samples[i];
    const std::uint64_t number = parameters.ensemble.input_of(sample.number);
    if (number != last) data.draws.push_back(sample.summary.inputs);
    last = number;
    data.values.draw.push_back(data.draws.size() - 1);
  }
}

/// Puts the parts beside each other.
void join(const std::vector<Part>& parts, const std::vector<std::size_t>& common, CalibrationData& data) {
  std::set<std::size_t> used;
  Eigen::Index n = 0;
  for (const Part& part : parts) {
    used.insert(part.experiments.begin(), part.experiments.end());
    n += part.of_samples.cols();
  }
  data.experiments.assign(used.begin(), used.end());
  data.values.value.resize(std::ssize(common), n);
  data.as_read.resize(std::ssize(common), n);
  data.observed.error = Matrix::Zero(n, n);
  Matrix observed = Matrix::Constant(std::ssize(data.experiments), n, not_a_number);
  Eigen::Index first = 0;
  for (const Part& part : parts) {
    const Eigen::Index count = part.of_samples.cols();
    for (std::size_t i = 0; i < common.size(); ++i) {
      const auto row = std::ranges::lower_bound(part.samples, common[i]) - part.samples.begin();
      data.values.value.block(static_cast<Eigen::Index>(i), first, 1, count) = part.of_samples.row(row);
      data.as_read.block(static_cast<Eigen::Index>(i), first, 1, count) = part.as_read.row(row);
    }
    for (std::size_t i = 0; i < part.experiments.size(); ++i) {
      const auto row =
          std::ranges::lower_bound(data.experiments, part.experiments[i]) - data.experiments.begin();
      observed.block(row, first, 1, count) = part.of_experiments.row(static_cast<Eigen::Index>(i));
    }
    data.observed.error.block(first, first, count, count) = part.error;
    data.observed.blocks.push_back(part.block);
    data.observed.blocks.back().first = first;
    data.observed.blocks.back().count = count;
    first += count;
  }
  set_observed(observed, data.observed);
}

}  // namespace

Eigen::MatrixXd smooth_shape(const std::vector<double>& places) {
  const auto n = std::ssize(places);
  const double length = (places.back() - places.front()) / 3;
  Matrix shape = Matrix::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index k = 0; k < n; ++k)
      if (i != k) shape(i, k) = std::exp(-std::pow((places[index(i)] - places[index(k)]) / length, 2) / 2);
  return shape;
}

void set_observed(const Eigen::MatrixXd& values, ObservedComponents& observed) {
  const Matrix has = values.array().isNaN().select(Matrix::Zero(values.rows(), values.cols()), 1.0);
  const Matrix known = values.array().isNaN().select(0.0, values);
  const Eigen::VectorXd count = has.colwise().sum();
  observed.mean = known.colwise().sum().transpose().cwiseQuotient(count);
  observed.share = (has.transpose() * has).cwiseQuotient(count * count.transpose());
  std::vector<Eigen::Index> whole;
  for (Eigen::Index i = 0; i < has.rows(); ++i)
    if (has.row(i).minCoeff() > 0) whole.push_back(i);
  const Eigen::Index n = std::ssize(whole);
  observed.contrasts.resize(std::max<Eigen::Index>(0, n - 1), values.cols());
  // Helmert's: each experiment against the mean of those before.
  for (Eigen::Index i = 1; i < n; ++i) {
    const std::vector<Eigen::Index> before(whole.begin(), whole.begin() + i);
    const auto k = static_cast<double>(i);
    observed.contrasts.row(i - 1) =
        std::sqrt(k / (k + 1)) * (values.row(whole[index(i)]) - values(before, Eigen::all).colwise().mean());
  }
}

CalibrationData calibration_data(std::span<const Experiment> experiments, const ObservedSamples& samples,
                                 const geometry::Body& body, const input::Parameters& parameters) {
  CalibrationData data{.random = parameters.random};
  const auto observables = observe(experiments, samples, body, 0);
  const auto parts = usable_parts(observables, samples.samples.size(), data);
  if (parts.empty())
    fail("experiments and samples have nothing in common that could calibrate inputs{}",
         data.notes.empty() ? "" : ": " + data.notes.front());
  const auto common = common_samples(parts, samples, parameters.random.size(), data);
  set_draws(common, samples, parameters, data);
  join(parts, common, data);
  if (experiments.size() > 1 &&
      std::ranges::any_of(experiments, [](const auto& e) { return !e.tips.empty(); }))
    data.notes.emplace_back("tip_times is not used: only with a single experiment");
  return data;
}

}  // namespace crackle::experiment
