// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/study.h"

#include <string>
#include <vector>

namespace crackle::input {

/// Warnings about valid but implausible values, such as a Young's modulus of "32000 mPa": one sentence each,
/// with the probable mistake.
std::vector<std::string> plausibility_warnings(const Study& study);

/// Largest speed of the body at the start [m/s]; of a free body relative to its middle.
double initial_speed(const Model& model, bool is_free = false);

}  // namespace crackle::input
