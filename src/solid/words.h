// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/failure.h"
#include "common/vector.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <system_error>

namespace crackle::solid {

/// The words of a text, one after the other.
class Words {
public:
  explicit Words(std::string_view text, std::size_t line = 1) : rest_(text), line_(line) {}

  std::size_t line() const { return line_; }

  /// The next word; empty at the end of the text.
  std::string_view next() {
    skip(" \t\r\n");
    const std::string_view word = rest_.substr(0, rest_.find_first_of(" \t\r\n"));
    rest_.remove_prefix(word.size());
    return word;
  }

  /// The rest of the line, without blanks around it; the next word is then that of the next line.
  std::string_view rest_of_line() {
    skip(" \t");
    std::string_view text = rest_.substr(0, rest_.find('\n'));
    rest_.remove_prefix(text.size());
    while (!text.empty() && (text.back() == '\r' || text.back() == ' ' || text.back() == '\t'))
      text.remove_suffix(1);
    return text;
  }

  /// The next word as a number. @throws std::runtime_error if it is none
  template <class Number>
  Number number() {
    std::string_view word = next();
    if (word.starts_with('+')) word.remove_prefix(1);
    Number value{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty()) fail("ends too early");
    if (error != std::errc{} || end != word.data() + word.size())
      fail("line {}: \"{}\" is not the number that must stand there", line_, word.substr(0, 40));
    return value;
  }

  Vector point() {
    Vector p{};
    for (double& coordinate : p) coordinate = number<double>();
    return p;
  }

  /// A number of things, each of which takes at least two more characters.
  std::size_t count() {
    const auto n = number<std::size_t>();
    if (n > rest_.size()) fail("line {}: {} entries are more than the file holds", line_, n);
    return n;
  }

private:
  void skip(std::string_view blanks) {
    const std::size_t n = std::min(rest_.find_first_not_of(blanks), rest_.size());
    for (const char c : rest_.substr(0, n)) line_ += c == '\n';
    rest_.remove_prefix(n);
  }

  std::string_view rest_;
  std::size_t line_;
};

}  // namespace crackle::solid
