// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>

namespace crackle::input {

/// More than any input needs. toml11's time grows with the square of the size: a second for this one.
inline constexpr std::size_t max_text_size = std::size_t{1} << 17;

/// What the TOML parser must not be given: bytes that are no text, invalid UTF-8, no content at all, or
/// nesting so deep that its recursion would exhaust the stack.
/// @throws SyntaxError
void check_text(const std::string& text);

}  // namespace crackle::input
