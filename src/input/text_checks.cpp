// SPDX-License-Identifier: GPL-3.0-or-later
#include "text_checks.h"

#include "document.h"

#include <fmt/format.h>

#include <string_view>

namespace crackle::input {

namespace {

/// Length of the valid UTF-8 sequence at the front of `text`, or 0.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  const bool overlong = (lead == 0xe0 && byte(1) < 0xa0) || (lead == 0xf0 && byte(1) < 0x90);
  const bool surrogate = lead == 0xed && byte(1) > 0x9f;
  const bool beyond_unicode = lead == 0xf4 && byte(1) > 0x8f;
  return overlong || surrogate || beyond_unicode ? 0 : length;
}

void check_characters(const std::string& text) {
  int line = 1;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    const bool control = static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\n' && c != '\r';
    if (control || c == 0x7f) {
      throw SyntaxError(line, fmt::format("not a text file (byte 0x{:02x}); give an input file in TOML",
                                          static_cast<unsigned char>(c)));
    }
    const std::size_t length = utf8_length(std::string_view(text).substr(i));
    if (length == 0) {
      throw SyntaxError(line, fmt::format("not valid UTF-8 (byte 0x{:02x}); give an input file in TOML",
                                          static_cast<unsigned char>(c)));
    }
    if (c == '\n') ++line;
    i += length;
  }
}

void check_nesting(const std::string& text) {
  constexpr int max_depth = 32;
  int line = 1;
  int depth = 0;
  int dots = 0;
  char quote = 0;  // the delimiter of the string that the scan is in
  bool long_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') {
      ++line;
      dots = 0;
      if (!long_string) quote = 0;
    } else if (quote != 0) {
      if (c == '\\' && quote == '"') {
        if (i + 1 < text.size() && text[i + 1] != '\n') ++i;
      } else if (c == quote) {
        if (!long_string) {
          quote = 0;
        } else if (text.compare(i, 3, std::string(3, quote)) == 0) {
          quote = 0;
          i += 2;
        }
      }
    } else if (c == '"' || c == '\'') {
      quote = c;
      long_string = text.compare(i, 3, std::string(3, c)) == 0;
      if (long_string) i += 2;
    } else if (c == '#') {
      while (i + 1 < text.size() && text[i + 1] != '\n') ++i;
    } else if (c == '[' || c == '{') {
      ++depth;
      dots = 0;
    } else if (c == ']' || c == '}') {
      --depth;
    } else if (c == '.') {
      ++dots;
    } else if (c == '=' || c == ',') {
      dots = 0;
    }
    if (depth > max_depth || dots > max_depth) {
      throw SyntaxError(line, fmt::format("nested more than {} deep; no key needs that", max_depth));
    }
  }
}

}  // namespace

void check_text(const std::string& text) {
  if (text.size() > max_text_size) {
    throw SyntaxError(1, fmt::format("longer than {} bytes; give an input file in TOML", max_text_size));
  }
  check_characters(text);
  check_nesting(text);
}

}  // namespace crackle::input
