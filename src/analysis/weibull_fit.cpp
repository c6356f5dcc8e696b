// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/weibull_fit.h"

#include "analysis/statistics.h"
#include "common/index.h"
#include "common/random.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/tools/minima.hpp>
#include <boost/math/tools/roots.hpp>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace crackle::analysis {

namespace {

constexpr int fewest_broken = 5;
constexpr int most_steps = 40;      // of Newton's method
constexpr int most_doublings = 30;  // of an interval's reach
constexpr double values_simulated = 1e6;

/// Logarithms of values, of which the first `n_broken` are known and the others are bounds.
struct Logarithms {
  std::vector<double> of;
  int n_broken;

  double mean_broken() const {
    double sum = 0;
    for (int i = 0; i < n_broken; ++i) sum += of[index(i)];
    return sum / n_broken;
  }
};

/// Parameters of the most likely distribution of logarithms.
struct Likely {
  double location;  ///< ln(scale)
  double modulus;
};

double most_likely_location(const Logarithms& logarithms, double modulus, double top) {
  double sum = 0;
  for (const double one : logarithms.of) sum += std::exp(modulus * (one - top));
  return top + std::log(sum / logarithms.n_broken) / modulus;
}

/// By Newton's method on the derivative of the log-likelihood in the modulus.
Likely most_likely(const Logarithms& logarithms) {
  const double top = std::ranges::max(logarithms.of);
  const double mean = logarithms.mean_broken() - top;
  double sum = 0, squares = 0;
  for (const double one : logarithms.of) {
    sum += one - top;
    squares += (one - top) * (one - top);
  }
  const auto n = static_cast<double>(logarithms.of.size());
  double modulus = 1.2 / std::sqrt(squares / n - sum / n * sum / n);
  for (int i = 0; i < most_steps; ++i) {
    double weights = 0, first = 0, second = 0;
    for (const double one : logarithms.of) {
      const double below = one - top;
      const double weight = std::exp(modulus * below);
      weights += weight;
      first += weight * below;
      second += weight * below * below;
    }
    first /= weights;
    second /= weights;
    const double step = (first - mean - 1 / modulus) / (second - first * first + 1 / (modulus * modulus));
    modulus = std::max(modulus - step, modulus / 3);
    if (std::abs(step) < 1e-12 * modulus) break;
  }
  return {most_likely_location(logarithms, modulus, top), modulus};
}

/// The logarithm of the likelihood but for a constant.
double log_likelihood(const Logarithms& logarithms, double modulus, double location) {
  double sum = 0;
  for (const double one : logarithms.of) sum += std::exp(modulus * (one - location));
  return logarithms.n_broken *
             (std::log(modulus) - modulus * location + (modulus - 1) * logarithms.mean_broken()) -
         sum;
}

/// Where the function falls by `fall` below that at `best`, before `end` or beyond.
template <class Of>
double end_of_interval(const Of& of, double best, double end, double fall) {
  const double limit = of(best) - fall;
  for (int i = 0; i < most_doublings && of(end) >= limit; ++i) end += end - best;
  if (of(end) >= limit) return end;
  std::uintmax_t n_steps = 200;
  const auto [low, high] = boost::math::tools::toms748_solve(
      [&](double x) { return of(x) - limit; }, std::min(best, end), std::max(best, end),
      boost::math::tools::eps_tolerance<double>(40), n_steps);
  return 0.5 * (low + high);
}

/// Intervals by the likelihood ratio.
void add_ratio_intervals(WeibullFit& fit, const Logarithms& logarithms, const Likely& likely,
                         double confidence) {
  const double fall = boost::math::quantile(boost::math::chi_squared(1), confidence) / 2;
  const double top = std::ranges::max(logarithms.of);
  const auto of_modulus = [&](double logarithm) {
    const double modulus = std::exp(logarithm);
    return log_likelihood(logarithms, modulus, most_likely_location(logarithms, modulus, top));
  };
  const auto of_location = [&](double location) {
    const auto found = boost::math::tools::brent_find_minima(
        [&](double logarithm) { return -log_likelihood(logarithms, std::exp(logarithm), location); },
        std::log(likely.modulus / 30), std::log(likely.modulus * 10), 40);
    return -found.second;
  };
  const double modulus = std::log(likely.modulus);
  const double most = std::log(50);
  const double reach =
      2 * (top - *std::min_element(logarithms.of.begin(), logarithms.of.begin() + logarithms.n_broken));
  fit.modulus = {likely.modulus, std::exp(end_of_interval(of_modulus, modulus, modulus - most, fall)),
                 std::exp(end_of_interval(of_modulus, modulus, modulus + most, fall))};
  fit.scale = {std::exp(likely.location),
               std::exp(end_of_interval(of_location, likely.location, likely.location - reach, fall)),
               std::exp(end_of_interval(of_location, likely.location, likely.location + reach, fall))};
}

/// Intervals by the distributions of the pivots, of samples of the distribution with scale and modulus 1.
void add_exact_intervals(WeibullFit& fit, std::size_t n, const Likely& likely, double confidence) {
  const int n_trials =
      static_cast<int>(std::clamp(values_simulated / static_cast<double>(n), 500.0, 10'000.0));
  std::vector<double> modulus, location;
  double sum = 0;
  Logarithms trial{std::vector<double>(n), static_cast<int>(n)};
  for (int i = 0; i < n_trials; ++i) {
    RandomStream random(0, static_cast<std::uint64_t>(i), "Weibull's pivots");
    for (double& one : trial.of) one = std::log(-std::log1p(-random.uniform()));
    const Likely found = most_likely(trial);
    modulus.push_back(found.modulus);
    location.push_back(-found.location * found.modulus);
    sum += found.modulus;
  }
  const double low = 0.5 - confidence / 2, high = 0.5 + confidence / 2;
  fit.modulus = {likely.modulus / (sum / n_trials), likely.modulus / quantile(modulus, high),
                 likely.modulus / quantile(modulus, low)};
  const auto end = [&](double share) {
    return std::exp(likely.location + quantile(location, share) / likely.modulus);
  };
  fit.scale = {std::exp(likely.location), end(low), end(high)};
}

}  // namespace

std::optional<WeibullFit> weibull_fit(const CensoredValues& values, double confidence) {
  WeibullFit fit;
  fit.n_unbroken = values.n_bounds();
  fit.n_broken = static_cast<int>(values.size()) - fit.n_unbroken;
  const bool are_positive = std::ranges::all_of(values.value, [](double one) { return one > 0; });
  if (fit.n_broken < fewest_broken || !are_positive) return {};
  Logarithms logarithms{{}, fit.n_broken};
  for (const bool is_bound : {false, true})
    for (std::size_t i = 0; i < values.size(); ++i)
      if (values.is_bound[i] == is_bound) logarithms.of.push_back(std::log(values.value[i]));
  const auto broken = std::span(logarithms.of).first(index(fit.n_broken));
  if (std::ranges::min(broken) == std::ranges::max(broken)) return {};
  const Likely likely = most_likely(logarithms);
  if (fit.n_unbroken == 0)
    add_exact_intervals(fit, values.size(), likely, confidence);
  else
    add_ratio_intervals(fit, logarithms, likely, confidence);
  return fit;
}

std::vector<LoadFit> weibull_fits(std::span<const SampleSummary> samples, double confidence) {
  std::vector<LoadFit> fits;
  for_each_result([&](const ResultInfo& info, auto member) {
    const std::string_view name = info.name;
    if (name != "first_break_load" && name != "peak_load") return;
    if (const auto fit = weibull_fit(observations(info, member, samples, 1), confidence))
      fits.push_back({info, *fit});
  });
  return fits;
}

}  // namespace crackle::analysis
