// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/reader.h"

#include "check_cost.h"
#include "check_trial.h"

#include <optional>
#include <string>
#include <vector>

namespace crackle::apps {

/// Prints one line for each case of a sweep.
void print_cases(const std::vector<input::Case>& cases);

/// Prints the cases after the first, whose warnings are known already: new warnings, the cost if that of the
/// first is known, and the outcome of the samples to be tried.
/// @return reasons why samples would fail, each with its case
std::vector<std::string> print_other_cases(const std::vector<input::Case>& cases,
                                           const std::optional<SampleTime>& first, const TrialExtent& extent);

}  // namespace crackle::apps
