// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

/// Parts of readable texts.
namespace crackle::experiment {

/// With blanks for underscores.
std::string readable(std::string name);

/// "3 failed (4, 17, 88)"
std::string named(const std::vector<std::uint64_t>& samples, std::string_view what);

/// Magnitude that chooses the unit of values in one sentence or row; NaN are left out.
double largest_magnitude(std::initializer_list<double> values);

}  // namespace crackle::experiment
