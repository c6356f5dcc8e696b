// SPDX-License-Identifier: GPL-3.0-or-later
#include "check_trial.h"

#include "crackle/common/heartbeat.h"
#include "crackle/common/quantity_text.h"

#include "commands.h"

#include <fmt/format.h>

#include <algorithm>

namespace crackle::apps {

std::vector<std::string> try_samples(const Subject& subject, const geometry::MotherPoints& base,
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

}  // namespace crackle::apps
