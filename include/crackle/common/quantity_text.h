// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace crackle {

/// A unit that people read values in.
struct ShownUnit {
  std::string name;   ///< such as "um^2"
  double factor = 1;  ///< from SI
};

/// The usual unit of a table's column or, where its largest value would be below `least` or above a million
/// in that, the one with the prefix that brings it to 1 to 1000.
/// @param usual such as {"mm^2", 1e6} of an area
/// @param si the SI unit: a symbol, which takes the prefix, and what follows it, such as "m^2" or "J/m^2"
/// @param largest magnitude in SI; 0 and NaN choose the usual unit
ShownUnit shown_unit(const ShownUnit& usual, const std::string& si, double largest, double least = 0.01);

/// "78.2 N", "40 us", "9.54 nN": a value in the SI unit given, with four digits and a prefix where it is
/// small or large.
std::string quantity_text(double value, const std::string& si);

}  // namespace crackle
