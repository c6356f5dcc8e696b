// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// Parts of readable texts.
namespace crackle::experiment {

using Row = std::vector<std::string>;

/// Columns of equal width; the first two and the last one begin at the left.
std::string columns(const std::vector<Row>& rows);

/// "0.034"; "-" for NaN
std::string probability(double p);

/// With blanks for underscores.
std::string readable(std::string name);

/// "3 failed (4, 17, 88)"
std::string named(const std::vector<std::uint64_t>& samples, std::string_view what);

}  // namespace crackle::experiment
