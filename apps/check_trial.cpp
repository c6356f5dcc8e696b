// SPDX-License-Identifier: GPL-3.0-or-later
#include "check_trial.h"

#include "crackle/common/heartbeat.h"
#include "crackle/common/quantity_text.h"
#include "crackle/common/stopwatch.h"

#include "commands.h"

#include <fmt/format.h>

#include <algorithm>

namespace crackle::apps {

namespace {

/// Stresses of samples at time 0 were seen to differ by up to 1.5 between meshes of one body.
constexpr double near_strength = 0.6;
constexpr int most_samples = 20;
constexpr double most_seconds = 10;

}  // namespace

std::vector<std::string> try_samples(const FirstSample& subject, const geometry::MotherPoints& base,
                                     const TrialExtent& extent) {
  const input::Parameters& parameters = subject.parameters;
  Heartbeat heartbeat(notify);
  ensemble::Trial trial(parameters, subject.body, base, extent.depth);
  const auto n = std::clamp<std::int64_t>(extent.samples, 1, parameters.ensemble.samples);
  std::vector<std::string> failures;
  for (std::int64_t i = 0; i < n; ++i) {
    heartbeat.begin(n == 1 ? "starting sample 0"
                           : fmt::format("starting sample {} ({} of {}); {} would fail so far", i, i + 1, n,
                                         failures.size()));
    const bool is_made = i == 0 && parameters.random.empty();
    const std::string failure =
        is_made ? trial.failure({.sample = 0, .realization = subject.realization, .error = {}})
                : trial.failure(static_cast<std::uint64_t>(i));
    if (!failure.empty()) failures.push_back(fmt::format("sample {} would fail: {}", i, failure));
  }
  if (extent.samples > 0) fmt::print("\nOf {}, {} would fail.\n", count_text(n, "sample"), failures.size());
  return failures;
}

std::vector<std::string> try_scatter_at_start(const FirstSample& subject, const geometry::MotherPoints& base,
                                              double share) {
  const input::Parameters& parameters = subject.parameters;
  const int n_others = std::min(parameters.ensemble.samples - 1, most_samples);
  if (!(share > near_strength) || n_others == 0) return {};
  Heartbeat heartbeat(notify);
  ensemble::Trial trial(parameters, subject.body, base, ensemble::TrialDepth::start);
  std::vector<std::string> failures;
  int n_tried = 0, n_failed = 0;
  for (const Stopwatch watch; n_tried < n_others && (n_tried == 0 || watch.seconds() < most_seconds);) {
    ++n_tried;
    heartbeat.begin(fmt::format("starting sample {}, since stresses at time 0 scatter", n_tried));
    const std::string failure = trial.failure(static_cast<std::uint64_t>(n_tried));
    if (failure.empty()) continue;
    if (n_failed++ == 0) failures.push_back(fmt::format("sample {} would fail: {}", n_tried, failure));
  }
  fmt::print("\nAt time 0 the stress in sample 0 is {:.3g} % of the strength; of {} more, {} would fail.{}\n",
             100 * share, count_text(n_tried, "sample"), n_failed,
             n_tried + 1 < parameters.ensemble.samples ? " --samples tries more." : "");
  return failures;
}

}  // namespace crackle::apps
