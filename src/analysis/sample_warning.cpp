// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/sample_warning.h"

#include <fmt/format.h>

#include <cstddef>
#include <utility>

namespace crackle::analysis {

std::optional<std::string> sample_warning(std::uint64_t sample, const SampleSummary& summary) {
  if (summary.status != SampleStatus::done || !(summary.crack_speed_ratio > 1)) return std::nullopt;
  return fmt::format(
      "warning: sample {}: a crack speed of {:.0f} m/s is {:.2f} times the Rayleigh speed, the limit of an "
      "opening crack",
      sample, summary.crack_speed_max, summary.crack_speed_ratio);
}

std::vector<std::string> sample_warnings(std::span<const SampleSummary> samples) {
  std::vector<std::string> warnings;
  for (std::size_t sample = 0; sample < samples.size(); ++sample)
    if (auto warning = sample_warning(sample, samples[sample])) warnings.push_back(std::move(*warning));
  return warnings;
}

}  // namespace crackle::analysis
