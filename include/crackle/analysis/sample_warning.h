// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace crackle::analysis {

/// "warning: sample 3: ..." for a sample whose crack was faster than the Rayleigh speed; else nothing.
std::optional<std::string> sample_warning(std::uint64_t sample, const SampleSummary& summary);

/// The warnings of an ensemble, given from sample 0 on.
std::vector<std::string> sample_warnings(std::span<const SampleSummary> samples);

}  // namespace crackle::analysis
