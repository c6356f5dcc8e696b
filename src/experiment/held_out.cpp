// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/experiment/held_out.h"

#include "crackle/common/failure.h"
#include "crackle/common/index.h"
#include "crackle/common/random.h"
#include "crackle/experiment/matching.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::experiment {

namespace {

ObservedSamples without(const ObservedSamples& samples, std::size_t i) {
  ObservedSamples others = samples;
  others.samples.erase(others.samples.begin() + static_cast<std::ptrdiff_t>(i));
  return others;
}

}  // namespace

Experiment as_experiment(const ObservedSample& sample) {
  Experiment experiment{.name = fmt::format("sample {}", sample.number)};
  const int start = sample.summary.leading_start;
  if (start >= 0 && index(start) < sample.arms.size() && !sample.arms[index(start)].empty()) {
    const auto length = [](const TimedLine& arm) { return length_of(arm.points); };
    experiment.lines = {std::ranges::max_element(sample.arms[index(start)], {}, length)->points};
    experiment.is_arrested = true;
  }
  const auto given = [](double load) { return std::isnan(load) ? std::optional<double>{} : load; };
  experiment.onset_load = given(load_of(sample.summary, Quantity::onset_load));
  experiment.peak_load = given(load_of(sample.summary, Quantity::peak_load));
  return experiment;
}

HeldOut hold_out(ObservedSamples samples, std::size_t n) {
  if (n < 1 || n + 2 > samples.samples.size())
    fail("of {} samples 1 to {} can be held out, not {}", samples.samples.size(),
         std::max<std::size_t>(samples.samples.size(), 2) - 2, n);
  RandomStream random(samples.seed, 0, "match: held out");
  HeldOut held{.experiments = {}, .others = std::move(samples)};
  auto& others = held.others.samples;
  for (std::size_t k = 0; k < n; ++k) {
    const auto i = static_cast<std::ptrdiff_t>(random.uniform() * static_cast<double>(others.size()));
    held.experiments.push_back(as_experiment(others[index(i)]));
    others.erase(others.begin() + i);
  }
  return held;
}

std::vector<double> p_values_of_samples(const ObservedSamples& samples, const geometry::Body& body,
                                        const std::function<void(std::size_t)>& on_progress) {
  std::vector<double> p_values;
  for (std::size_t i = 0; i < samples.samples.size(); ++i) {
    p_values.push_back(match_one(as_experiment(samples.samples[i]), without(samples, i), body).p_value);
    on_progress(i + 1);
  }
  return p_values;
}

std::string p_values_text(std::vector<double> p_values) {
  std::erase_if(p_values, [](double p) { return std::isnan(p); });
  std::string text = fmt::format("{} samples, each as an experiment against the others\n", p_values.size());
  for (const double level : {0.05, 0.1, 0.25, 0.5, 0.75}) {
    const auto n = std::ranges::count_if(p_values, [&](double p) { return p <= level + rounding; });
    text += fmt::format(
        "p <= {:<4}  {:>5.1f} % of them\n", level,
        100.0 * static_cast<double>(n) / static_cast<double>(std::max<std::size_t>(1, p_values.size())));
  }
  return text;
}

std::string p_values_json(const ObservedSamples& samples, const std::vector<double>& p_values) {
  auto list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < p_values.size(); ++i)
    list.push_back({{"sample", samples.samples[i].number}, {"p_value", p_values[i]}});
  return list.dump(1, ' ') + "\n";
}

}  // namespace crackle::experiment
