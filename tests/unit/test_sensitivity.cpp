// SPDX-License-Identifier: GPL-3.0-or-later
// Sensitivities of results with known values, written into the rows of samples, and the coverage of
// intervals.
#include "analysis/exceedance.h"
#include "analysis/sensitivity.h"
#include "common/random.h"
#include "input/reader.h"
#include "uncertainty/random_inputs.h"

#include "input_samples.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

namespace crackle::analysis {
namespace CRACKLE_TEST_FILE {

using ::testing::HasSubstr;

constexpr std::array keys{"material.youngs_modulus", "material.density", "fracture.strength"};

/// Three inputs with the same distribution, with parameters in units of GPa, kg/m^3 and MPa.
input::Parameters study(int samples, int replicates, const std::string& distribution,
                        const std::array<std::string, 3>& parameters, int seed = 0,
                        const std::string& plan = "sobol") {
  auto tables = test::minimal_tables();
  test::set_key(tables, "[ensemble]", "samples", std::to_string(samples));
  test::set_key(tables, "[ensemble]", "seed", std::to_string(seed));
  test::set_key(tables, "[ensemble]", "plan", '"' + plan + '"');
  test::set_key(tables, "[ensemble]", "replicates", std::to_string(replicates));
  std::string text = test::to_text(tables);
  for (std::size_t k = 0; k < 3; ++k)
    text += fmt::format("[[random]]\nkey = \"{}\"\ndistribution = \"{}\"\n{}\n", keys[k], distribution,
                        parameters[k]);
  return input::parse(text, "plate.toml");
}

using Function = std::function<double(const std::vector<double>& inputs, std::uint64_t sample)>;

std::vector<SampleSummary> rows_of(const input::Parameters& parameters, const Function& function) {
  std::vector<SampleSummary> rows;
  for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(parameters.ensemble.samples); ++i) {
    SampleSummary row = empty_summary(1, 1, SampleStatus::done);
    row.inputs = uncertainty::drawn_values(parameters, i);
    row.peak_load = function(row.inputs, i);
    rows.push_back(row);
  }
  return rows;
}

Sensitivity of_peak_load(const input::Parameters& parameters, const std::vector<SampleSummary>& rows) {
  for (const Sensitivity& one : sensitivities(parameters, rows).results)
    if (std::string(one.info.name) == "peak_load") return one;
  return {};
}

TEST(Sensitivity, OfIshigamisFunction) {
  // Ishigami and Homma (1990), a = 7, b = 0.1: inputs uniform from -pi to pi, here around 1000 of each unit.
  const std::array<std::string, 3> around{"lower = \"999 GPa\"\nupper = \"1001 GPa\"",
                                          "lower = \"999 kg/m^3\"\nupper = \"1001 kg/m^3\"",
                                          "lower = \"999 MPa\"\nupper = \"1001 MPa\""};
  const auto parameters = study(512, 1, "uniform", around);
  const auto rows = rows_of(parameters, [](const std::vector<double>& v, std::uint64_t) {
    const double pi = std::numbers::pi;
    const double x = pi * (v[0] / 1e9 - 1000), y = pi * (v[1] - 1000), z = pi * (v[2] / 1e6 - 1000);
    return std::sin(x) + 7 * std::pow(std::sin(y), 2) + 0.1 * std::pow(z, 4) * std::sin(x);
  });
  const Sensitivity found = of_peak_load(parameters, rows);
  ASSERT_EQ(found.inputs.size(), 3u);
  const std::array first{0.3139, 0.4424, 0.0}, total{0.5576, 0.4424, 0.2437};
  for (std::size_t k = 0; k < 3; ++k) {
    std::printf("input %zu: first %.3f (exact %.3f), total %.3f (exact %.3f)\n", k,
                found.inputs[k].first.value, first[k], found.inputs[k].total.value, total[k]);
    EXPECT_NEAR(found.inputs[k].first.value, first[k], 0.03);
    EXPECT_NEAR(found.inputs[k].total.value, total[k], 0.03);
  }
  EXPECT_GT(found.predicted, 0.95);
  EXPECT_TRUE(std::isnan(found.lack_of_fit)) << "no replicates";
  EXPECT_TRUE(std::isnan(found.mesh.value)) << "no replicates";
}

/// Additive, with shares 0.5, 0.2 and 0 of the inputs and 0.3 of independent normal scatter per sample,
/// representing the mesh.
double additive(const input::Parameters& parameters, const std::vector<double>& v, std::uint64_t sample) {
  const double x = (v[0] / 1e9 - 100) / 1, y = v[1] - 1000;
  const RandomStream stream(parameters.seed, sample, "scatter of a test");
  double scatter = -6;  // a sum of twelve uniform numbers is approximately normal
  for (std::uint64_t i = 0; i < 12; ++i) scatter += stream.substream(i).uniform();
  return std::sqrt(0.5) * x + std::sqrt(0.2) * y + std::sqrt(0.3) * scatter;
}

const std::array<std::string, 3> normal_inputs{"mean = \"100 GPa\"\nstandard_deviation = \"1 GPa\"",
                                               "mean = \"1000 kg/m^3\"\nstandard_deviation = \"1 kg/m^3\"",
                                               "mean = \"1000 MPa\"\nstandard_deviation = \"1 MPa\""};

TEST(Sensitivity, IntervalsHoldAsOftenAsTheySay) {
  constexpr int n_studies = 60;
  const std::array exact{0.5, 0.2, 0.3};  // of two inputs and of the mesh
  std::array<int, 3> hits{};
  std::array<double, 3> mean{};
  int n_rank_hits = 0;
  for (int seed = 0; seed < n_studies; ++seed) {
    const auto parameters = study(192, 2, "normal", normal_inputs, seed, "independent");
    const auto rows =
        rows_of(parameters, [&](const auto& v, std::uint64_t i) { return additive(parameters, v, i); });
    const Sensitivity found = of_peak_load(parameters, rows);
    ASSERT_EQ(found.inputs.size(), 3u);
    const std::array estimates{found.inputs[0].total, found.inputs[1].total, found.mesh};
    for (std::size_t k = 0; k < 3; ++k) {
      mean[k] += estimates[k].value / n_studies;
      hits[k] += estimates[k].lower <= exact[k] && exact[k] <= estimates[k].upper ? 1 : 0;
    }
    // Spearman's coefficient of a normal pair with correlation r is 6/pi asin(r/2).
    const double rank = 6 / std::numbers::pi * std::asin(std::sqrt(0.5) / 2);
    const Estimate& of_rank = found.inputs[0].rank_correlation;
    n_rank_hits += of_rank.lower <= rank && rank <= of_rank.upper ? 1 : 0;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    std::printf("share %.1f: mean estimate %.3f, inside the 95 %% interval in %d of %d studies\n", exact[k],
                mean[k], hits[k], n_studies);
    EXPECT_NEAR(mean[k], exact[k], 0.02);
    EXPECT_GE(hits[k], 51) << "95 % of 60 are 57; fewer than 51 happen once in 200";
  }
  std::printf("rank correlation inside in %d\n", n_rank_hits);
  EXPECT_GE(n_rank_hits, 51);
}

TEST(Sensitivity, AJumpIsALackOfFitButTheMeshIsNot) {
  const auto parameters = study(128, 2, "normal", normal_inputs);
  const auto text_of = [&](const Function& function) {
    const auto rows = rows_of(parameters, function);
    const Sensitivities all = sensitivities(parameters, rows);
    return std::pair(of_peak_load(parameters, rows).lack_of_fit, to_text(all, parameters));
  };
  // A checkerboard of the first two inputs.
  const auto [jump, of_jump] = text_of([](const auto& v, std::uint64_t) {
    return std::sin(4 * (v[0] / 1e9 - 100)) * std::sin(4 * (v[1] - 1000)) > 0 ? 500.0 : 100.0;
  });
  EXPECT_GT(jump, 0.7);
  EXPECT_THAT(of_jump, HasSubstr("lack of fit"));
  EXPECT_THAT(of_jump, HasSubstr("!: the expansion does not follow"));
  const auto [smooth, of_smooth] =
      text_of([&](const auto& v, std::uint64_t i) { return additive(parameters, v, i); });
  EXPECT_LT(smooth, 0.15);
  EXPECT_THAT(of_smooth, ::testing::Not(HasSubstr("!:")));
}

/// The number of a start is not a quantity: start 1, which leads where the modulus is near its mean, has a
/// share.
TEST(Sensitivity, TheLeadingStartIsAName) {
  auto parameters = study(64, 1, "normal", normal_inputs);
  for (const double at : {0.03, 0.06, 0.09})
    parameters.specimen.notches.push_back(
        {.face = plane::Face::y_min, .at = at, .depth = 0.003, .height = 0.001});
  auto rows = rows_of(parameters, [](const auto& v, std::uint64_t) { return v[0]; });
  for (SampleSummary& row : rows)
    row.leading_start = row.peak_load < 99.5e9 ? 0 : row.peak_load < 100.5e9 ? 1 : 2;
  std::vector<std::string> shares;
  for (const Sensitivity& one : sensitivities(parameters, rows).results)
    if (std::string(one.info.name) == "leading_notch") {
      shares.push_back(one.share_of);
      EXPECT_NEAR(one.inputs[0].rank_correlation.value,
                  one.share_of == "1"   ? 0
                  : one.share_of == "0" ? -0.8
                                        : 0.8,
                  0.1);
    }
  EXPECT_THAT(shares, ::testing::ElementsAre("0", "1", "2"));
  EXPECT_THROW(exceedance("leading_notch > 0", rows), std::runtime_error);
}

TEST(Sensitivity, IntervalsErrByThePlan) {
  const auto note = [](int replicates, const std::string& plan) {
    return note_on_plan(study(64, replicates, "normal", normal_inputs, 0, plan));
  };
  EXPECT_EQ(note(1, "independent"), "");
  EXPECT_EQ(note(2, "independent"), "") << "intervals are by whole draws";
  for (const char* const plan : {"sobol", "latin-hypercube"})
    for (const int replicates : {1, 2}) {
      EXPECT_THAT(note(replicates, plan), HasSubstr(plan));
      EXPECT_THAT(note(replicates, plan), HasSubstr("wider than need be"));
      EXPECT_THAT(note(replicates, plan), ::testing::Not(HasSubstr("narrow")));
    }
  EXPECT_EQ(note_on_plan(input::parse(test::to_text(test::minimal_tables()), "plate.toml")), "");
}

TEST(Sensitivity, OfAResultThatOwesNothingToTheInputs) {
  const auto parameters = study(64, 2, "normal", normal_inputs);
  const auto rows = rows_of(parameters, [](const auto&, std::uint64_t i) {
    return RandomStream(1, i, "scatter of a test").substream(0).uniform();
  });
  const Sensitivity found = of_peak_load(parameters, rows);
  EXPECT_GT(found.mesh.value, 0.6);
  for (const InputEffect& input : found.inputs) EXPECT_LT(input.total.value, 0.15);
  // A constant predicts best, and an interval of zero width would claim that the index is exactly 0.
  EXPECT_EQ(found.degree, 0);
  for (const InputEffect& input : found.inputs) {
    EXPECT_EQ(input.total.value, 0);
    EXPECT_TRUE(std::isnan(input.total.lower) && std::isnan(input.first.upper));
    EXPECT_FALSE(std::isnan(input.rank_correlation.lower));
  }
}

TEST(Sensitivity, OfAResultThatFewSamplesHaveTakesFewTerms) {
  const auto parameters = study(512, 1, "normal", normal_inputs);
  // All 512 draws support the 10 terms up to squares; the 18 with a value do not, although they would fit.
  const auto found_with = [&](std::uint64_t every) {
    const auto rows = rows_of(parameters, [&](const auto& v, std::uint64_t i) {
      return i % every == 0 ? v[0] * v[0] : not_a_number;
    });
    return of_peak_load(parameters, rows).degree;
  };
  EXPECT_GE(found_with(1), 2);
  EXPECT_LE(found_with(30), 1);
}

/// Loads of bars as strength times modulus, which stands for a width: indices 0.632, 0.355.
const std::array<std::string, 3> of_bars{"lower = \"1.5 GPa\"\nupper = \"2.5 GPa\"",
                                         "lower = \"900 kg/m^3\"\nupper = \"1100 kg/m^3\"",
                                         "lower = \"20 MPa\"\nupper = \"40 MPa\""};

TEST(Sensitivity, OfLoadsIsThatOfAllDrawsAndOfOthersThatOfTheDrawsThatBroke) {
  const auto parameters = study(64, 1, "uniform", of_bars, 3);
  auto rows = rows_of(parameters, [](const auto& v, std::uint64_t) { return v[0] * v[2] / 1e15; });
  for (SampleSummary& row : rows) {
    const bool breaks = row.peak_load < 60;
    row.outcome = breaks ? 2 : 0;
    row.onset_force = breaks ? row.peak_load : not_a_number;
    row.peak_load = std::min(row.peak_load, 60.0);
    row.work_of_fracture = row.peak_load;  // of those that did not break a lower one
  }
  const Sensitivities all = sensitivities(parameters, rows);
  int n_found = 0;
  for (const Sensitivity& one : all.results) {
    if (one.info.of_unbroken == OfUnbroken::value) continue;
    ++n_found;
    std::printf("%s: %d draws, %d bounds, first %.3f, %.3f, %.3f\n", one.info.name, one.n_draws, one.n_bounds,
                one.inputs[2].first.value, one.inputs[0].first.value, one.inputs[1].first.value);
    // With a bound in place of every second value the indices are less sharp.
    const double tolerance = one.n_bounds > 0 ? 0.09 : 0.03;
    EXPECT_NEAR(one.inputs[2].first.value, 0.632, tolerance);
    EXPECT_NEAR(one.inputs[0].first.value, 0.355, tolerance);
    EXPECT_NEAR(one.inputs[1].first.value, 0, 0.01);
    const int n_known = one.n_draws - one.n_bounds;
    EXPECT_TRUE(25 < n_known && n_known < 45) << n_known;
    EXPECT_EQ(one.n_draws == 64, one.info.of_unbroken == OfUnbroken::bound) << one.info.name;
  }
  EXPECT_EQ(n_found, 3);
  EXPECT_THAT(to_text(all, parameters),
              ::testing::AllOf(HasSubstr("some results are of fewer draws, such as those that broke"),
                               HasSubstr("by a censored regression")));
}

TEST(Sensitivity, CorrelatedInputsDoNotShareTheVariance) {
  auto parameters = study(64, 1, "uniform", of_bars, 3);
  parameters.correlations = {{{keys[0], keys[2]}, 0.5}};
  const auto rows = rows_of(parameters, [](const auto& v, std::uint64_t) { return v[0] * v[2] / 1e15; });
  const Sensitivity found = of_peak_load(parameters, rows);
  for (const InputEffect& input : found.inputs)
    EXPECT_TRUE(std::isnan(input.first.value) && std::isnan(input.total.upper));
  EXPECT_GT(found.inputs[0].rank_correlation.value, 0.6);
  EXPECT_GT(found.predicted, 0.99);
  EXPECT_THAT(to_text(sensitivities(parameters, rows), parameters), HasSubstr("the inputs are correlated"));
}

TEST(Sensitivity, SaysAtWhichEndOfAnInputDrawsFail) {
  const auto parameters = study(32, 1, "uniform", of_bars, 5);
  auto rows = rows_of(parameters, [](const auto&, std::uint64_t i) {
    return RandomStream(1, i, "scatter of a test").substream(0).uniform();
  });
  for (SampleSummary& row : rows)
    if (row.inputs[2] < 28e6) row.status = SampleStatus::failed;
  const Sensitivities all = sensitivities(parameters, rows);
  EXPECT_THAT(all.failures,
              ::testing::MatchesRegex("the 1[0-9] draws that failed all lie at the lower end of "
                                      "fracture.strength: 2.* MPa to 2.* MPa, the others 2.*"));
  EXPECT_THAT(all.failures, ::testing::Not(HasSubstr("density")));
  EXPECT_THAT(to_text(all, parameters), HasSubstr(all.failures));
  // Of a result that owes nothing to the inputs, an expansion beyond the draws done explains nothing.
  for (const Sensitivity& one : all.results)
    for (const InputEffect& input : one.inputs)
      EXPECT_LE(input.total.value, std::max(0.0, one.predicted) + 0.3) << one.info.name;
  rows[3].status = rows[3].status == SampleStatus::done ? SampleStatus::failed : SampleStatus::done;
  EXPECT_THAT(sensitivities(parameters, rows).failures, HasSubstr("lie mostly at the lower end"));
  for (std::size_t i = 0; i < rows.size(); ++i)
    rows[i].status = i % 3 == 0 ? SampleStatus::failed : SampleStatus::done;
  EXPECT_EQ(sensitivities(parameters, rows).failures, "");
}

TEST(Sensitivity, TotalIndicesAreNoSmallerThanFirstOnes) {
  for (int seed = 0; seed < 20; ++seed) {
    const auto parameters = study(96, 2, "normal", normal_inputs, seed, "independent");
    const auto rows = rows_of(parameters, [&](const auto& v, std::uint64_t i) {
      return std::pow(v[0] / 1e9 - 99, 2) + additive(parameters, v, i);
    });
    for (const InputEffect& input : of_peak_load(parameters, rows).inputs) {
      EXPECT_GE(input.total.value, input.first.value);
      EXPECT_LE(input.total.value, 1);
    }
  }
}

TEST(Sensitivity, NeedsDrawsAndRandomInputs) {
  const auto parameters = study(8, 1, "normal", normal_inputs);
  const auto few = rows_of(parameters, [](const auto& v, std::uint64_t) { return v[0]; });
  EXPECT_TRUE(sensitivities(parameters, few).results.empty());
  EXPECT_THAT(to_text(sensitivities(parameters, few), parameters), HasSubstr("too few draws"));
  const auto certain = input::parse(test::to_text(test::minimal_tables()), "plate.toml");
  EXPECT_EQ(to_text(sensitivities(certain, {}), certain), "");
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::analysis
