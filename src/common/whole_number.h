// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <charconv>
#include <concepts>
#include <optional>
#include <string_view>
#include <system_error>

namespace crackle {

/// Parses a text that consists entirely of a whole number: digits, with a leading minus sign for signed
/// types. Empty for any other text (blanks, a plus sign, "0x10") and for numbers out of the type's range.
template <std::integral Integer>
std::optional<Integer> whole_number(std::string_view text) {
  Integer value{};
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  if (result.ec != std::errc{} || result.ptr != end) return std::nullopt;
  return value;
}

}  // namespace crackle
