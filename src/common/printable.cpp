// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/printable.h"

#include <boost/locale/utf.hpp>

#include <new>

namespace crackle {

namespace {

namespace utf = boost::locale::utf;

bool is_control(utf::code_point c) {
  return (c < 0x20 && c != '\t' && c != '\n') || (c >= 0x7f && c < 0xa0);
}

bool turns_the_text(utf::code_point c) {
  return (c >= 0x202a && c <= 0x202e) || (c >= 0x2066 && c <= 0x2069);
}

}  // namespace

std::string printable(std::string_view text) {
  std::string result;
  for (auto next = text.begin(); next != text.end();) {
    const auto first = next;
    const utf::code_point c = utf::utf_traits<char>::decode(next, text.end());
    if (c == utf::illegal || c == utf::incomplete) {
      result += '?';
      next = first + 1;
    } else if (is_control(c) || turns_the_text(c)) {
      result += '?';
    } else {
      result.append(first, next);
    }
  }
  return result;
}

std::string reason_of(const std::exception& failure) {
  if (dynamic_cast<const std::bad_alloc*>(&failure) == nullptr) return failure.what();
  return std::string("there is not enough memory (") + failure.what() + ")";
}

}  // namespace crackle
