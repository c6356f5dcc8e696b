// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>

namespace crackle {

/// A unit for display.
struct ShownUnit {
  std::string name;   ///< such as "um^2"
  double factor = 1;  ///< from SI
};

/// The usual unit of a table's column or, if its largest value in that unit is below `least` or above a
/// million, the one with the prefix that brings it into the range 1 to 1000.
/// @param usual such as {"mm^2", 1e6} of an area
/// @param si the SI unit: a symbol, which takes the prefix, and the rest, such as "m^2" or "J/m^2"
/// @param largest magnitude in SI; 0 and NaN choose the usual unit
ShownUnit shown_unit(const ShownUnit& usual, const std::string& si, double largest, double least = 0.01);

/// "78.2 N", "40 us", "9.54 nN": a value in the given SI unit, with a prefix if it is small or large.
std::string quantity_text(double value, const std::string& si, int n_digits = 4);

/// The same in the unit that suits the largest magnitude of those it is compared with: "-0.014 N" beside "12
/// N".
std::string quantity_text(double value, const std::string& si, int n_digits, double largest);

/// The value that six significant digits give, so that no more need to be written.
double to_six_digits(double value);

/// "1 sample", "2 samples": a number of what the noun names.
std::string count_text(std::int64_t n, std::string_view noun);
std::string count_text(std::integral auto n, std::string_view noun) {
  return count_text(static_cast<std::int64_t>(n), noun);
}

}  // namespace crackle
