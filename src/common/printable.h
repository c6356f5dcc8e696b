// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <exception>
#include <string>
#include <string_view>

namespace crackle {

/// Text from a file or a command line as it may be printed: a question mark for each control character other
/// than a tab or the end of a line, for what changes the direction of writing, and for bytes that are not
/// UTF-8. A terminal obeys the former; JSON has no place for the latter.
std::string printable(std::string_view text);

/// The first line of a file, without the byte order mark that some editors put before it.
constexpr std::string_view without_mark(std::string_view line) {
  constexpr std::string_view mark = "\xef\xbb\xbf";
  return line.starts_with(mark) ? line.substr(mark.size()) : line;
}

/// The message of a failure; of a failed allocation a sentence.
std::string reason_of(const std::exception& failure);

}  // namespace crackle
