// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibration_steps.h"

#include "crackle/common/index.h"
#include "crackle/experiment/path_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::experiment {

namespace {

constexpr std::size_t n_predictions = 2000;

/// A number that depends linearly on the components.
struct Linear {
  std::string name, unit;
  Eigen::VectorXd weight;
  double constant = 0;
};

/// Components of new experiments' means, one a row.
Eigen::MatrixXd new_means(const SyntheticLikelihood& likelihood, const PosteriorPoints& points,
                          const RandomStream& stream) {
  const auto chosen = resampled(points.weight, n_predictions, stream);
  Eigen::MatrixXd means;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const auto [mean, covariance] = likelihood.expected(points.point[chosen[i]]);
    RandomStream random = stream.substream(i);
    Eigen::VectorXd x(mean.size());
    for (double& each : x) each = random.normal();
    // By Wilson and Hilferty: chi-squared over its degrees of freedom.
    const double v = 2 / (9 * likelihood.degrees_of_freedom());
    const double spread = std::pow(1 - v + std::sqrt(v) * random.normal(), 3);
    means.conservativeResize(std::ssize(chosen), mean.size());
    means.row(static_cast<Eigen::Index>(i)) =
        mean + Eigen::LLT<Eigen::MatrixXd>(covariance).matrixL() * x / std::sqrt(std::max(spread, 1e-3));
  }
  return means;
}

Prediction predict(const Linear& what, const Eigen::MatrixXd& means, const Eigen::VectorXd& observed) {
  const Eigen::VectorXd values = (means * what.weight).array() + what.constant;
  Prediction one{.name = what.name, .unit = what.unit};
  one.predicted = spread_of({values.begin(), values.end()},
                            Eigen::VectorXd::Constant(values.size(), 1 / static_cast<double>(values.size())));
  one.observed = what.weight.dot(observed) + what.constant;
  one.place =
      static_cast<double>((values.array() < one.observed).count()) / static_cast<double>(values.size());
  return one;
}

}  // namespace

void add_predictions(const CalibrationData& data, const SyntheticLikelihood& likelihood,
                     const PosteriorPoints& points, const RandomStream& stream, Calibration& calibration) {
  const Eigen::MatrixXd means = new_means(likelihood, points, stream);
  const Eigen::Index n = means.cols();
  const auto add = [&](const Linear& what, std::vector<Prediction>& to) {
    to.push_back(predict(what, means, data.observed.mean));
  };
  for (const QuantityBlock& block : data.observed.blocks) {
    if (data.path && block.first == 0) continue;
    for (Eigen::Index k = 0; k < block.count; ++k)
      add({block.count == 1 ? block.name : fmt::format("{}[{}]", block.name, k), block.unit,
           Eigen::VectorXd::Unit(n, block.first + k)},
          calibration.predictions);
  }
  if (!data.path) return;
  const PathComponents& path = *data.path;
  const auto offset = [&](const std::string& name, const Eigen::VectorXd& of_stations) {
    Linear what{name, "m", Eigen::VectorXd::Zero(n), of_stations.dot(path.mean)};
    what.weight.head(path.basis.cols()) = path.basis.transpose() * of_stations;
    return what;
  };
  const Eigen::Index n_stations = path.mean.size();
  add(offset("path, mean offset", Eigen::VectorXd::Constant(n_stations, 1 / static_cast<double>(n_stations))),
      calibration.predictions);
  add(offset("path, offset at its end", Eigen::VectorXd::Unit(n_stations, n_stations - 1)),
      calibration.predictions);
  calibration.path = PredictedPath{path.frame, path.stations};
  for (Eigen::Index k = 0; k < n_stations; ++k)
    add(offset("", Eigen::VectorXd::Unit(n_stations, k)), calibration.path->at);
}

}  // namespace crackle::experiment
