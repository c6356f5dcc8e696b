// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/sensitivity.h"

#include "analysis/grouped_values.h"
#include "analysis/result_list.h"
#include "common/failure.h"
#include "common/index.h"
#include "common/quantity_text.h"
#include "common/random.h"
#include "common/real.h"
#include "geometry/body.h"
#include "input/reader.h"

#include "chaos_expansion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <boost/math/distributions/normal.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <string_view>
#include <type_traits>

namespace crackle::analysis {

namespace {

constexpr int n_bootstrap_draws = 400;
/// Minimum number of draws per random input.
constexpr std::size_t least_draws_per_input = 4;

/// One result, and how to read it from a row; NaN if missing.
struct Subject {
  Sensitivity of;
  std::function<double(const SampleSummary&)> value;
  std::function<bool(const SampleSummary&)> is_bound = {};  ///< the value lies above it; empty: never
};

/// @param n_starts crack starts of the body
void add_result(const ResultInfo& info, const std::function<double(const SampleSummary&)>& value,
                int n_starts, std::vector<Subject>& subjects) {
  if (!info.is_nominal()) {
    subjects.push_back({{.info = info}, value});
    return;
  }
  const bool is_start = *info.categories == 0;
  const int n = is_start ? n_starts : n_categories(info.categories);
  for (int category = 0; category < n; ++category) {
    Sensitivity of{.info = info};
    of.share_of = is_start ? std::to_string(category) : category_name(info.categories, category);
    subjects.push_back({of, [value, category](const SampleSummary& row) {
                          const double found = value(row);
                          return std::isnan(found) ? found : found == category ? 1.0 : 0.0;
                        }});
  }
}

std::vector<Subject> all_subjects(const input::Study& study, std::size_t n_positions) {
  std::vector<Subject> subjects;
  const auto n_starts = static_cast<int>(geometry::n_crack_starts(study));
  for_each_result([&](const ResultInfo& info, auto member) {
    if (info.about == About::computation) return;
    add_result(
        info, [info, member](const SampleSummary& row) { return observed(info, member, row).value; },
        n_starts, subjects);
    if (info.of_unbroken == OfUnbroken::bound)
      subjects.back().is_bound = [info](const SampleSummary& row) { return is_bound(info, row); };
  });
  const std::size_t n_sections = study.sections.size();
  for_each_position_result([&](const ResultInfo& info, auto member) {
    if constexpr (std::is_same_v<decltype(member), decltype(&SampleSummary::position)>) {
      if (member != &SampleSummary::position) return;
      for (std::size_t k = 0; k < n_positions; ++k) {
        Sensitivity of{.info = info};
        of.start = static_cast<int>(k / n_sections);
        of.section = static_cast<int>(k % n_sections);
        subjects.push_back({of, [k](const SampleSummary& row) { return row.position[k]; }});
      }
    }
  });
  return subjects;
}

/// The draws of the random inputs, and the rows of each.
struct Draws {
  std::vector<std::vector<double>> values;  ///< draws x inputs
  std::vector<std::size_t> of_row;          ///< of the completed rows
  std::vector<const SampleSummary*> row;
};

Draws draws_of(const input::Study& study, std::span<const SampleSummary> rows) {
  Draws draws;
  std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].status != SampleStatus::done || rows[i].inputs.size() != study.random.size()) continue;
    const std::uint64_t number = study.ensemble.input_of(i);
    if (number != last) draws.values.push_back(rows[i].inputs);
    last = number;
    draws.of_row.push_back(draws.values.size() - 1);
    draws.row.push_back(&rows[i]);
  }
  return draws;
}

/// Values of one input in the draws that failed on any mesh, and in the others.
struct FailedValues {
  std::vector<double> failed, others;
};

FailedValues failed_values(const input::Study& study, std::span<const SampleSummary> rows,
                           std::size_t input) {
  FailedValues found;
  for (std::size_t i = 0; i < rows.size();) {
    const std::uint64_t draw = study.ensemble.input_of(i);
    bool has_failed = false, is_known = false;
    double value = not_a_number;
    for (; i < rows.size() && study.ensemble.input_of(i) == draw; ++i) {
      if (rows[i].status == SampleStatus::pending || rows[i].inputs.size() <= input) continue;
      has_failed = has_failed || rows[i].status == SampleStatus::failed;
      is_known = true;
      value = rows[i].inputs[input];
    }
    if (is_known && std::isfinite(value)) (has_failed ? found.failed : found.others).push_back(value);
  }
  return found;
}

/// Two-sided p of Wilcoxon's rank-sum test in its normal approximation; negative if the failed ones are the
/// smaller.
double rank_sum_probability(const FailedValues& values) {
  const auto m = static_cast<double>(values.failed.size()), n = static_cast<double>(values.others.size());
  double excess = 0;
  for (const double one : values.failed)
    for (const double other : values.others) excess += one > other ? 0.5 : one < other ? -0.5 : 0;
  const double z = excess / std::sqrt(m * n * (m + n + 1) / 12);
  return std::copysign(2 * boost::math::cdf(boost::math::normal(), -std::abs(z)), excess);
}

std::string where_draws_fail(const input::Study& study, std::span<const SampleSummary> rows) {
  constexpr double clear = 0.01;
  std::string text;
  for (std::size_t k = 0; k < study.random.size(); ++k) {
    const input::RandomInput& random = study.random[k];
    const FailedValues values = failed_values(study, rows, k);
    if (values.failed.empty() || values.others.empty()) return {};
    const double probability = rank_sum_probability(values);
    if (!(std::abs(probability) * static_cast<double>(study.random.size()) < clear)) continue;
    const auto [least, most] = std::ranges::minmax(values.failed);
    const auto [least_other, most_other] = std::ranges::minmax(values.others);
    const auto range = [&](double from, double to) {
      const bool has_unit = !random.unit.empty() && random.unit != "1";
      return has_unit
                 ? fmt::format("{} to {}", quantity_text(from, random.unit), quantity_text(to, random.unit))
                 : fmt::format("{:.4g} to {:.4g}", from, to);
    };
    text += fmt::format("{}the {} that failed {} at the {} end of {}: {}, the others {}",
                        text.empty() ? "" : "; ", count_text(std::ssize(values.failed), "draw"),
                        most < least_other || least > most_other ? "all lie" : "lie mostly",
                        probability < 0 ? "lower" : "upper", random.key, range(least, most),
                        range(least_other, most_other));
  }
  return text.empty() ? text : text + ". All numbers hold for draws that do not fail";
}

/// Bootstrap samples, as the multiplicity of each draw.
std::vector<Eigen::VectorXd> bootstrap_counts(std::size_t n_draws) {
  std::vector<Eigen::VectorXd> samples;
  for (int b = 0; b < n_bootstrap_draws; ++b) {
    RandomStream stream = RandomStream(0, 0, "bootstrap of draws").substream(static_cast<std::uint64_t>(b));
    Eigen::VectorXd counts = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n_draws));
    for (std::size_t i = 0; i < n_draws; ++i) {
      const auto k = static_cast<std::size_t>(stream.uniform() * static_cast<double>(n_draws));
      counts[static_cast<Eigen::Index>(std::min(k, n_draws - 1))] += 1;
    }
    samples.push_back(std::move(counts));
  }
  return samples;
}

/// An estimate with an interval as wide as the scatter of its bootstrap samples about their mean; the bias of
/// the mean is due to the bootstrap itself and is ignored.
Estimate with_interval(double value, std::vector<double> samples, double confidence, double least) {
  std::erase_if(samples, [](double sample) { return std::isnan(sample); });
  Estimate estimate{std::clamp(value, least, 1.0)};
  if (samples.size() < n_bootstrap_draws / 2 || std::isnan(value)) return estimate;
  const double mean =
      std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(samples.size());
  std::ranges::sort(samples);
  const auto quantile = [&](double share) {
    return samples[static_cast<std::size_t>(share * static_cast<double>(samples.size() - 1) + 0.5)];
  };
  estimate.lower = std::clamp(value + quantile((1 - confidence) / 2) - mean, least, 1.0);
  estimate.upper = std::clamp(value + quantile((1 + confidence) / 2) - mean, least, 1.0);
  return estimate;
}

/// Ranks from 1; ties share the mean of their ranks.
Eigen::VectorXd ranks_of(const Eigen::VectorXd& values) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](Eigen::Index i) { return values[i]; });
  Eigen::VectorXd ranks(values.size());
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && values[order[end]] == values[order[begin]]) ++end;
    for (std::size_t i = begin; i < end; ++i) ranks[order[i]] = (static_cast<double>(begin + end) + 1) / 2;
  }
  return ranks;
}

double correlation(const Eigen::VectorXd& x, const Eigen::VectorXd& y, const Eigen::VectorXd& weight) {
  const double n = weight.sum();
  const Eigen::ArrayXd dx = x.array() - weight.dot(x) / n, dy = y.array() - weight.dot(y) / n;
  const double scale = std::sqrt((weight.array() * dx.square()).sum() * (weight.array() * dy.square()).sum());
  return scale > 0 ? (weight.array() * dx * dy).sum() / scale : not_a_number;
}

/// The share of the variance within draws, by one-way random-effects analysis of variance; NaN if no draw has
/// several values.
/// @param count of each value: multiplicity of its draw
double share_within(const DrawnValues& values, const Eigen::VectorXd& count) {
  const auto list = [](const Eigen::VectorXd& of) { return std::span(of.data(), index(of.size())); };
  return 1 - variance_components(list(values.value), values.draw, list(count)).intraclass;
}

/// Data common to all results.
struct CommonData {
  const input::Study& study;
  Draws draws;
  ChaosBasis basis;
  std::vector<Eigen::VectorXd> samples;  ///< bootstrap_counts
  double confidence;
};

/// @param bounds receives those of the values that are lower bounds
DrawnValues values_of(const CommonData& common, const Subject& subject, std::vector<std::size_t>& bounds) {
  DrawnValues values;
  std::vector<double> found;
  for (std::size_t i = 0; i < common.draws.row.size(); ++i) {
    const double value = subject.value(*common.draws.row[i]);
    if (std::isnan(value)) continue;
    if (subject.is_bound && subject.is_bound(*common.draws.row[i])) bounds.push_back(found.size());
    values.draw.push_back(common.draws.of_row[i]);
    found.push_back(value);
  }
  values.value = Eigen::Map<const Eigen::VectorXd>(found.data(), static_cast<Eigen::Index>(found.size()));
  return values;
}

/// Replaces lower bounds by draws from what lies above them, of a normal distribution about the expansion: a
/// censored regression by expectation and maximization (Tobin 1958, Econometrica 26, 24).
void draw_above(const ChaosBasis& basis, const std::vector<std::size_t>& bounds, DrawnValues& values) {
  const boost::math::normal normal;
  const auto at = [](std::size_t i) { return static_cast<Eigen::Index>(i); };
  const Eigen::VectorXd given = values.value;
  Eigen::VectorXd mean;
  double deviation = 0, more = 0;
  constexpr int most_steps = 50;
  for (int step = 0; step < most_steps; ++step) {
    const int degree = choose_degree(basis, values).degree;
    mean = fitted_values(basis, values, degree);
    const auto degrees = std::max<Eigen::Index>(1, given.size() - basis.n_terms(degree));
    deviation = std::sqrt(((values.value - mean).squaredNorm() + more) / static_cast<double>(degrees));
    if (deviation == 0) return;
    more = 0;
    double change = 0;
    for (const std::size_t i : bounds) {
      const double a = (given[at(i)] - mean[at(i)]) / deviation;
      constexpr double far = 30;
      const double hazard = a > far ? a : pdf(normal, a) / cdf(complement(normal, a));
      const double expected = mean[at(i)] + deviation * hazard;
      change = std::max(change, std::abs(expected - values.value[at(i)]));
      values.value[at(i)] = expected;
      more += deviation * deviation * std::max(0.0, 1 - hazard * (hazard - a));
    }
    if (change < 1e-4 * deviation) break;
  }
  RandomStream stream(0, 0, "above bounds");
  for (const std::size_t i : bounds) {
    const double above = cdf(complement(normal, (given[at(i)] - mean[at(i)]) / deviation));
    const double p = std::clamp(above * stream.uniform(), 1e-300, 1.0);
    values.value[at(i)] = std::max(given[at(i)], mean[at(i)] + deviation * quantile(complement(normal, p)));
  }
}

/// Expands counts of draws to counts of values.
Eigen::VectorXd spread_out(const Eigen::VectorXd& of_draws, const std::vector<std::size_t>& draw) {
  Eigen::VectorXd counts(static_cast<Eigen::Index>(draw.size()));
  for (std::size_t i = 0; i < draw.size(); ++i)
    counts[static_cast<Eigen::Index>(i)] = of_draws[static_cast<Eigen::Index>(draw[i])];
  return counts;
}

void estimate(const CommonData& common, const DrawnValues& values, Sensitivity& result) {
  const std::size_t n_inputs = common.study.random.size();
  const Eigen::VectorXd once = Eigen::VectorXd::Ones(values.value.size());
  const ChosenDegree chosen = choose_degree(common.basis, values);
  result.degree = chosen.degree;
  result.predicted = chosen.predicted;
  const SobolIndices indices = sobol_indices(common.basis, values, chosen.degree, once, true);

  const Eigen::VectorXd ranks = ranks_of(values.value);
  std::vector<Eigen::VectorXd> input_ranks;
  for (std::size_t k = 0; k < n_inputs; ++k) {
    Eigen::VectorXd input(values.value.size());
    for (Eigen::Index i = 0; i < input.size(); ++i) input[i] = common.draws.values[values.draw[index(i)]][k];
    input_ranks.push_back(ranks_of(input));
  }

  std::vector<double> mesh;
  std::vector<std::vector<double>> first(n_inputs), total(n_inputs), rank(n_inputs);
  for (const Eigen::VectorXd& sample : common.samples) {
    const Eigen::VectorXd counts = spread_out(sample, values.draw);
    mesh.push_back(share_within(values, counts));
    const SobolIndices again = sobol_indices(common.basis, values, chosen.degree, counts, false);
    for (std::size_t k = 0; k < n_inputs; ++k) {
      first[k].push_back(again.first[k]);
      total[k].push_back(again.total[k]);
      rank[k].push_back(correlation(input_ranks[k], ranks, counts));
    }
  }
  result.mesh = with_interval(share_within(values, once), mesh, common.confidence, 0);
  if (!std::isnan(result.mesh.value))
    result.lack_of_fit = std::max(0.0, 1 - result.mesh.value - std::max(0.0, chosen.predicted));
  for (std::size_t k = 0; k < n_inputs; ++k) {
    InputEffect effect;
    // A constant predicts best: the indices are 0, but their uncertainty is unknown. Of dependent inputs they
    // are no shares.
    if (!common.study.correlations.empty()) {
    } else if (chosen.degree == 0) {
      effect.first.value = effect.total.value = 0;
    } else {
      effect.first = with_interval(indices.first[k], first[k], common.confidence, 0);
      effect.total = with_interval(indices.total[k], total[k], common.confidence, 0);
    }
    effect.rank_correlation =
        with_interval(correlation(input_ranks[k], ranks, once), rank[k], common.confidence, -1);
    result.inputs.push_back(effect);
  }
}

}  // namespace

Sensitivities sensitivities(const input::Study& study, std::span<const SampleSummary> rows,
                            double confidence) {
  Sensitivities all{.confidence = confidence};
  if (study.random.empty()) return all;
  all.failures = where_draws_fail(study, rows);
  Draws draws = draws_of(study, rows);
  all.n_draws = static_cast<int>(draws.values.size());
  all.n_samples = static_cast<int>(draws.row.size());
  const std::size_t least = least_draws_per_input * (study.random.size() + 1);
  if (draws.values.size() < least) return all;
  const std::size_t n_positions = draws.row.front()->position.size();
  ChaosBasis basis(study.random, draws.values);
  auto samples = bootstrap_counts(draws.values.size());
  const CommonData common{study, std::move(draws), std::move(basis), std::move(samples), confidence};
  for (Subject& subject : all_subjects(study, n_positions)) {
    std::vector<std::size_t> bounds;
    DrawnValues values = values_of(common, subject, bounds);
    const auto n_bounds = static_cast<std::ptrdiff_t>(bounds.size());
    if (values.n_draws() < least || values.value.minCoeff() == values.value.maxCoeff() ||
        2 * n_bounds > values.value.size())
      continue;
    if (n_bounds > 0) draw_above(common.basis, bounds, values);
    subject.of.n_bounds = static_cast<int>(n_bounds);
    subject.of.n_values = static_cast<int>(values.value.size());
    subject.of.n_draws = static_cast<int>(values.n_draws());
    estimate(common, values, subject.of);
    all.results.push_back(std::move(subject.of));
  }
  return all;
}

}  // namespace crackle::analysis
