// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dimension.h"

#include <memory>
#include <string>
#include <string_view>

struct ut_system;

namespace crackle::input {

/// Why a text is not the expected quantity.
enum class QuantityError { none, no_number, no_unit, unknown_unit, wrong_dimension, not_finite };

struct Quantity {
  double value = 0;  ///< [SI unit of the dimension]; 0 on error
  QuantityError error = QuantityError::none;
  std::string unit;  ///< the unit's text
};

/// The UDUNITS unit database.
class UnitSystem {
public:
  /// @throws std::runtime_error when the database cannot be read
  UnitSystem();

  /// Reads "<number> <unit>" and converts it to the SI unit of `dimension`.
  Quantity read(const std::string& text, const Dimension& dimension) const;

  /// The program's database, read once, since that takes longer than reading an input.
  static const UnitSystem& shared();

private:
  Quantity convert(double number, const std::string& unit, const Dimension& dimension) const;

  std::unique_ptr<ut_system, void (*)(ut_system*)> system_;
};

/// Without leading and trailing blanks.
std::string_view trimmed(std::string_view text);

}  // namespace crackle::input
