// SPDX-License-Identifier: GPL-3.0-or-later
#include "document.h"

#include <fmt/format.h>
#include <boost/locale/utf.hpp>

namespace crackle::input {

namespace {

void check_characters(const std::string& text) {
  namespace utf = boost::locale::utf;
  int line = 1;
  for (auto next = text.begin(); next != text.end();) {
    const char c = *next;
    const bool control = static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\n' && c != '\r';
    if (control || c == 0x7f) {
      throw SyntaxError(line, fmt::format("not a text file (byte 0x{:02x}); give an input file in TOML",
                                          static_cast<unsigned char>(c)));
    }
    const utf::code_point point = utf::utf_traits<char>::decode(next, text.end());
    if (point == utf::illegal || point == utf::incomplete) {
      throw SyntaxError(line, fmt::format("not valid UTF-8 (byte 0x{:02x}); give an input file in TOML",
                                          static_cast<unsigned char>(c)));
    }
    if (c == '\n') ++line;
  }
}

void check_nesting(const std::string& text) {
  constexpr int max_depth = 32;
  int line = 1;
  int depth = 0;
  int dots = 0;
  char quote = 0;  // delimiter of the current string
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
