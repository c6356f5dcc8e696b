// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_results.h"

#include <span>
#include <string>
#include <vector>

namespace crackle::analysis {

using TextTable = std::vector<std::vector<std::string>>;  ///< rows of equally many cells

/// The table with its first columns, and the last one if wanted, aligned to the left and the others to the
/// right.
std::string aligned(const TextTable& table, std::size_t n_left = 1, bool is_last_left = false);

/// A number in the syntax of fmt, such as ".3f", times a factor; "-" for NaN.
std::string shown(double value, const std::string& format, double factor = 1);

/// The same, with "> " before a bound.
std::string shown(const Observation& one, const std::string& format, double factor = 1);

/// The format with as many decimals as the numbers that it shows deserve: three digits of their scatter or,
/// without scatter, five of their size; never more decimals than it has.
/// @param values in SI; NaN counts as none
std::string fitting_format(const std::string& format, std::span<const Observation> values, double factor = 1);

/// "lower to upper", likewise.
std::string shown_range(double lower, double upper, const std::string& format, double factor = 1);

/// A share, as "93 %".
std::string shown_percent(double share);

/// A p-value, as "0.034" or "< 0.001".
std::string shown_probability(double probability);

}  // namespace crackle::analysis
