// SPDX-License-Identifier: GPL-3.0-or-later
// Calibration: closed forms, and the promises of its intervals on made-up models.
#include "experiment/calibration_steps.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>

namespace crackle::experiment {
namespace CRACKLE_TEST_FILE {

using ::testing::HasSubstr;

input::RandomInput random_input(const std::string& key, double mean, double deviation) {
  return {.key = key, .mean = mean, .standard_deviation = deviation};
}

Eigen::VectorXd normals(Eigen::Index n, RandomStream stream) {
  Eigen::VectorXd x(n);
  for (double& each : x) each = stream.normal();
  return x;
}

/// A model of standard normal inputs, with scatter, and how it is observed.
struct MadeUp {
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> mean;
  Eigen::VectorXd scatter, error;  ///< standard deviations

  Eigen::VectorXd result(const Eigen::VectorXd& inputs, const RandomStream& stream) const {
    return mean(inputs) + scatter.cwiseProduct(normals(scatter.size(), stream.substream(0)));
  }
};

CalibrationData made_up_data(const MadeUp& model, Eigen::Index n_inputs, Eigen::Index n_draws, int replicates,
                             const RandomStream& stream) {
  CalibrationData data;
  const Eigen::Index n = model.scatter.size();
  for (Eigen::Index k = 0; k < n_inputs; ++k) data.random.push_back(random_input(fmt::format("{}", k), 0, 1));
  data.values.value.resize(n_draws * replicates, n);
  data.as_read.resize(n_draws * replicates, n);
  for (Eigen::Index i = 0; i < n_draws; ++i) {
    const RandomStream own = stream.substream(static_cast<std::uint64_t>(i));
    const Eigen::VectorXd inputs = normals(n_inputs, own.substream(0));
    data.draws.emplace_back(inputs.begin(), inputs.end());
    for (int r = 0; r < replicates; ++r) {
      const RandomStream of_sample = own.substream(static_cast<std::uint64_t>(1 + r));
      const Eigen::Index row = i * replicates + r;
      data.values.draw.push_back(static_cast<std::size_t>(i));
      data.values.value.row(row) = model.result(inputs, of_sample);
      data.as_read.row(row) = data.values.value.row(row).transpose() +
                              model.error.cwiseProduct(normals(n, of_sample.substream(1)));
    }
  }
  data.observed.error = model.error.array().square().matrix().asDiagonal();
  for (Eigen::Index c = 0; c < n; ++c)
    data.observed.blocks.push_back({fmt::format("result {}", c), "N", c, 1, Eigen::MatrixXd::Ones(1, 1)});
  return data;
}

/// Experiments with a model: results as read.
Eigen::MatrixXd experiments(const MadeUp& model, const Eigen::VectorXd& inputs, Eigen::Index n,
                            const RandomStream& stream) {
  Eigen::MatrixXd rows(n, model.scatter.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const RandomStream own = stream.substream(static_cast<std::uint64_t>(i));
    rows.row(i) =
        model.result(inputs, own) + model.error.cwiseProduct(normals(model.error.size(), own.substream(1)));
  }
  return rows;
}

/// Share of a posterior below the true inputs, in the middle 90 % or not, by experiments simulated one by
/// one.
double coverage(const MadeUp& model, const CalibrationData& data, Eigen::Index n_experiments, int n_trials,
                const CovarianceTerms& terms, const Eigen::RowVectorXd& bias = {}) {
  const Emulator emulator = emulator_of(data);
  const auto n_inputs = std::ssize(data.random);
  int n_covered = 0;
  for (int trial = 0; trial < n_trials; ++trial) {
    const RandomStream stream(1, static_cast<std::uint64_t>(trial), "simulated experiments");
    const Eigen::VectorXd truth = normals(n_inputs, stream.substream(0));
    ObservedComponents observed = data.observed;
    Eigen::MatrixXd values = experiments(model, truth, n_experiments, stream.substream(1));
    if (bias.size() > 0) values.rowwise() += bias;
    set_observed(values, observed);
    const PosteriorPoints points =
        posterior_of(SyntheticLikelihood(emulator, observed, terms), small_effort, stream.substream(2));
    for (Eigen::Index k = 0; k < n_inputs; ++k) {
      double below = 0;
      for (std::size_t i = 0; i < points.point.size(); ++i)
        if (points.point[i][k] < truth[k]) below += points.weight[static_cast<Eigen::Index>(i)];
      n_covered += std::abs(below - 0.5) <= 0.45;
    }
  }
  return n_covered / static_cast<double>(n_trials * n_inputs);
}

/// Two inputs, three results, mildly nonlinear.
MadeUp nonlinear() {
  return {[](const Eigen::VectorXd& x) {
            return Eigen::VectorXd{{std::exp(0.3 * x[0]) + 0.2 * x[1], 0.3 * x[1] + 0.2 * x[1] * x[0],
                                    0.5 * std::sin(x[0]) - 0.2 * x[1]}};
          },
          Eigen::VectorXd{{0.2, 0.25, 0.2}}, Eigen::VectorXd{{0.05, 0.05, 0.05}}};
}

TEST(Calibration, ABarHasThePosteriorOfTheClosedForm) {
  // Force E A e of a bar at a given strain, E normal; noise is that of reading.
  constexpr double mean = 70e9, deviation = 5e9, area = 1e-4, strain = 1e-3, error = 300;
  constexpr int n = 4;
  const double slope = area * strain;
  CalibrationData data;
  data.random = {random_input("material.youngs_modulus", mean, deviation)};
  data.random[0].unit = "Pa";
  const Eigen::VectorXd z = normals(60, RandomStream(3, 0, "bar"));
  data.values.value.resize(60, 1);
  for (Eigen::Index i = 0; i < 60; ++i) {
    data.draws.push_back({mean + deviation * z[i]});
    data.values.draw.push_back(static_cast<std::size_t>(i));
    data.values.value(i, 0) = slope * data.draws.back()[0];
  }
  data.as_read = data.values.value + error * normals(60, RandomStream(4, 0, "bar"));
  data.observed.error = Eigen::MatrixXd::Constant(1, 1, error * error);
  data.observed.blocks = {{"peak_load", "N", 0, 1, Eigen::MatrixXd::Ones(1, 1)}};
  const Eigen::VectorXd loads{{7600, 7900, 7400, 7700}};
  set_observed(loads, data.observed);
  const Calibration found = calibrate(data, {}, 1);

  const double precision = 1 / (deviation * deviation) + n * slope * slope / (error * error);
  const double expected =
      (mean / (deviation * deviation) + n * slope * loads.mean() / (error * error)) / precision;
  const double width = 1 / std::sqrt(precision);
  const Spread& posterior = found.inputs[0].posterior;
  std::printf("bar: mean %.4f (%.4f) GPa, deviation %.4f (%.4f), interval %.3f to %.3f (%.3f to %.3f)\n",
              posterior.mean / 1e9, expected / 1e9, posterior.standard_deviation / 1e9, width / 1e9,
              posterior.lower / 1e9, posterior.upper / 1e9, (expected - 1.6449 * width) / 1e9,
              (expected + 1.6449 * width) / 1e9);
  // Four standard errors with some 4000 points.
  EXPECT_NEAR(posterior.mean, expected, 0.065 * width);
  EXPECT_NEAR(posterior.standard_deviation, width, 0.045 * width);
  EXPECT_NEAR(posterior.lower, expected - 1.6449 * width, 0.15 * width);
  EXPECT_NEAR(posterior.upper, expected + 1.6449 * width, 0.15 * width);
  const double bits = (width * width / (deviation * deviation) + std::pow((expected - mean) / deviation, 2) -
                       1 - 2 * std::log(width / deviation)) /
                      (2 * std::log(2.0));
  EXPECT_NEAR(found.bits, bits, 0.06) << "Kullback-Leibler divergence of two normal distributions";
  EXPECT_NEAR(found.inputs[0].prior.mean, mean, 1e-4 * mean);
  EXPECT_NEAR(found.inputs[0].prior.standard_deviation, deviation, 1e-3 * deviation);
  EXPECT_GT(found.checks.effective_size, 2000);
  EXPECT_EQ(found.warnings, std::vector<std::string>{});
  EXPECT_EQ(to_json(found), to_json(calibrate(data, {}, 1)));
  EXPECT_THAT(posterior_tables(found), HasSubstr("[[random]]\nkey = \"material.youngs_modulus\"\n"
                                                 "distribution = \"normal\"\nmean = \""));
}

TEST(Calibration, TwoInputsThatOneResultCannotTellApart) {
  const MadeUp sum{[](const Eigen::VectorXd& x) { return Eigen::VectorXd{{x[0] + x[1]}}; },
                   Eigen::VectorXd{{0.1}}, Eigen::VectorXd{{0.1}}};
  CalibrationData data = made_up_data(sum, 2, 60, 1, RandomStream(5, 0, "sum"));
  set_observed(Eigen::MatrixXd::Constant(1, 1, 1.5), data.observed);
  const Calibration found = calibrate(data, {}, 1);
  // Noise 0.02 in variance; x0 + x1 is known to that, x0 - x1 not at all.
  const double noise = 0.02 + 0.01 * 3 / 60;
  for (const CalibratedInput& each : found.inputs) {
    EXPECT_NEAR(each.posterior.mean, 1.5 / (2 + noise), 0.06);
    EXPECT_NEAR(each.posterior.standard_deviation, std::sqrt(1 - 1 / (2 + noise)), 0.04);
  }
  EXPECT_NEAR(found.correlation[0][1], -(1 / (2 + noise)) / (1 - 1 / (2 + noise)), 0.02);
}

TEST(Calibration, AnEmulatorKnowsItsErrorAndReplicates) {
  const MadeUp model = nonlinear();
  const CalibrationData data = made_up_data(model, 2, 60, 4, RandomStream(6, 0, "replicates"));
  const Emulator emulator = emulator_of(data);
  const Eigen::VectorXd at{{0.3, -0.4}};
  EXPECT_LT((emulator.predict(at).mean - model.mean(at)).cwiseAbs().maxCoeff(), 0.1);
  for (Eigen::Index c = 0; c < 3; ++c)
    EXPECT_NEAR(std::sqrt(emulator.scatter()(c, c)), model.scatter[c], 0.15 * model.scatter[c]);
  // The sum of leverages over the samples is the number of terms.
  double sum = 0;
  for (std::size_t i = 0; i < data.draws.size(); ++i)
    sum += 4 * emulator.predict(Eigen::VectorXd{{data.draws[i][0], data.draws[i][1]}}).leverage[0];
  EXPECT_NEAR(sum, static_cast<double>(emulator.n_terms(0)), 1e-2);
  // A draw's own samples are left out with it.
  const Emulator without = emulator.refitted(data.values.without(3), {0, 1, 2});
  CalibrationData others = data;
  others.values = data.values.without(3);
  EXPECT_EQ(others.values.n_draws(), 59u);
  EXPECT_EQ(without.predict(at).mean, emulator.refitted(others.values, {0, 1, 2}).predict(at).mean);
  EXPECT_NE(without.predict(at).mean, emulator.predict(at).mean);
}

TEST(Calibration, IntervalsCoverSimulatedExperiments) {
  const MadeUp model = nonlinear();
  const CalibrationData data = made_up_data(model, 2, 30, 1, RandomStream(7, 0, "coverage"));
  const double with = coverage(model, data, 5, 100, {});
  const double without = coverage(model, data, 5, 100, {.has_emulator_error = false});
  std::printf("coverage of 90 %% intervals: %.3f, without the emulator's error %.3f\n", with, without);
  EXPECT_GE(with, 0.85);
  EXPECT_LE(with, 0.95);
  EXPECT_LT(without, with - 0.05);
}

TEST(Calibration, ABiasIsFlaggedOrAllowedFor) {
  // Two results for one input: a bias of one of them cannot be made up for.
  const MadeUp model{[](const Eigen::VectorXd& x) {
                       return Eigen::VectorXd{{x[0], 0.8 * x[0]}};
                     },
                     Eigen::VectorXd{{0.1, 0.1}}, Eigen::VectorXd{{0.03, 0.03}}};
  CalibrationData data = made_up_data(model, 1, 60, 1, RandomStream(8, 0, "bias"));
  const Eigen::RowVectorXd bias{{0.3, 0}};
  const double unbiased = coverage(model, data, 3, 60, {});
  const double biased = coverage(model, data, 3, 60, {}, bias);
  const double cured = coverage(model, data, 3, 60, {.has_discrepancy = true}, bias);
  std::printf("coverage: %.3f unbiased, %.3f biased, %.3f with a discrepancy\n", unbiased, biased, cured);
  EXPECT_GT(unbiased, 0.8);
  EXPECT_LT(biased, 0.5);
  EXPECT_GT(cured, 0.8);
  set_observed(Eigen::MatrixXd{{0.5, 1.0}}, data.observed);
  const Calibration wrong = calibrate(data, {}, 1);
  EXPECT_LE(wrong.checks.distance_p_value, 0.05);
  EXPECT_THAT(wrong.warnings, ::testing::Contains(HasSubstr("no value of the inputs explains them")));
  set_observed(Eigen::MatrixXd{{0.5, 0.4}}, data.observed);
  const Calibration right = calibrate(data, {}, 1);
  EXPECT_GT(right.checks.distance_p_value, 0.2);
  EXPECT_EQ(right.warnings, std::vector<std::string>{});
  EXPECT_LT(right.inputs[0].ratio(), calibrate(data, {.has_discrepancy = true}, 1).inputs[0].ratio());
}

TEST(Calibration, ScatterBetweenSpecimensIsFound) {
  const MadeUp model{[](const Eigen::VectorXd& x) { return Eigen::VectorXd{{x[0]}}; }, Eigen::VectorXd{{0.1}},
                     Eigen::VectorXd{{0.02}}};
  CalibrationData data = made_up_data(model, 1, 60, 1, RandomStream(9, 0, "specimens"));
  set_observed(Eigen::VectorXd{{-0.5, 0.7, 0.1, -0.9, 0.6, 0.2, -0.4, 0.9}}, data.observed);
  const Calibration plain = calibrate(data, {}, 1);
  const Calibration found = calibrate(data, {.has_specimen_scatter = true}, 1);
  ASSERT_EQ(found.scales.size(), 1u);
  EXPECT_FALSE(found.scales[0].is_discrepancy);
  EXPECT_LT(found.scales[0].posterior.lower, 0.63) << "standard deviation of the eight";
  EXPECT_GT(found.scales[0].posterior.upper, 0.63);
  EXPECT_GT(found.scales[0].posterior.lower, 0.3);
  EXPECT_GT(found.inputs[0].posterior.standard_deviation, 3 * plain.inputs[0].posterior.standard_deviation);
}

TEST(Calibration, ContributionsAndTooFewDraws) {
  // Each result tells one input.
  const MadeUp model{[](const Eigen::VectorXd& x) {
                       return Eigen::VectorXd{{x[0], x[1]}};
                     },
                     Eigen::VectorXd{{0.1, 0.1}}, Eigen::VectorXd{{0, 0}}};
  CalibrationData data = made_up_data(model, 2, 60, 1, RandomStream(10, 0, "contributions"));
  set_observed(Eigen::MatrixXd{{0.5, -0.5}}, data.observed);
  const Calibration found = calibrate(data, {}, 1);
  ASSERT_EQ(found.contributions.size(), 2u);
  for (const std::size_t k : {0u, 1u}) {
    const Contribution& one = found.contributions[k];
    EXPECT_LT(one.alone.inputs[k].standard_deviation, 0.2);
    EXPECT_NEAR(one.alone.inputs[1 - k].standard_deviation, 1, 0.15);
    EXPECT_NEAR(one.without->inputs[k].standard_deviation, 1, 0.15);
    EXPECT_NEAR(one.alone.bits + one.without->bits, found.bits, 0.3) << "independent";
  }
  for (const Prediction& each : found.predictions) {
    EXPECT_GT(each.place, 0.2);
    EXPECT_LT(each.place, 0.8);
    EXPECT_LT(each.predicted.standard_deviation, 0.3);
  }
  int n = 0;
  for (const int weight : found.weights) n += weight;
  EXPECT_EQ(n, 500);
  CalibrationData few = made_up_data(model, 2, 11, 1, RandomStream(10, 0, "contributions"));
  few.observed = data.observed;
  EXPECT_THAT([&] { calibrate(few, {}, 1); },
              ::testing::ThrowsMessage<std::runtime_error>(HasSubstr("are too few for an emulator")));
}

TEST(Calibration, ObservedMeansCountWhatEachExperimentHas) {
  ObservedComponents observed;
  set_observed(Eigen::MatrixXd{{1, not_a_number}, {3, 4}, {5, 8}}, observed);
  EXPECT_EQ(observed.mean, (Eigen::VectorXd{{3, 6}}));
  EXPECT_TRUE(observed.share.isApprox(Eigen::MatrixXd{{1.0 / 3, 1.0 / 3}, {1.0 / 3, 0.5}}));
  ASSERT_EQ(observed.contrasts.rows(), 1);
  EXPECT_TRUE(observed.contrasts.row(0).isApprox(Eigen::RowVectorXd{{std::sqrt(2.0), 2 * std::sqrt(2.0)}}));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::experiment
