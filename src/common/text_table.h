// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <utility>
#include <vector>

/// Tables for people: numbers as cells, and cells in columns.
namespace crackle {

using TextTable = std::vector<std::vector<std::string>>;  ///< rows of equally many cells

/// The table with its first columns, and the last one if wanted, aligned to the left and the others to the
/// right.
std::string aligned(const TextTable& table, std::size_t n_left = 1, bool is_last_left = false);

/// Key or name, and value.
using NamedValue = std::pair<std::string, std::string>;

/// "name = value" for each line, with values aligned.
/// @param between name and value
std::string aligned(const std::vector<NamedValue>& lines, const char* between = " = ");

/// A number in the syntax of fmt, such as ".3f", times a factor; "-" for NaN.
std::string shown(double value, const std::string& format, double factor = 1);

/// "lower to upper", likewise.
std::string shown_range(double lower, double upper, const std::string& format, double factor = 1);

/// A share, as "93 %".
std::string shown_percent(double share);

/// A p-value, as "0.034" or "< 0.001".
std::string shown_probability(double probability);

/// "label [unit]", or the label alone without a unit.
std::string with_unit(const std::string& label, const std::string& unit);

/// "0.25 s", "45 s", "12 min 30 s", "3 h 20 min", "2 d 3 h".
std::string duration_text(double seconds);

}  // namespace crackle
