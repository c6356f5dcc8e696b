// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>

namespace crackle {

inline constexpr double infinity = std::numeric_limits<double>::infinity();
/// Represents a missing number.
inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

}  // namespace crackle
