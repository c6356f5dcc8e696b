// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"

#include <string>
#include <vector>

namespace crackle::input {

/// Warnings about values that are accepted and that hardly anyone means, such as "32000 mPa" of Young's
/// modulus: one sentence each, with the slip that is likely behind it.
std::vector<std::string> plausibility_warnings(const Parameters& parameters);

}  // namespace crackle::input
