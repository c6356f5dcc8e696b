// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace crackle::input {

/// describe() names them in this order.
enum class ValueKind { boolean, integer, number, string, array, table, date };

struct Member;

/// One value of a TOML document with its location.
struct Value {
  ValueKind kind = ValueKind::table;
  int line = 1;
  std::size_t column = 1;     ///< of its first byte in that line
  std::size_t length = 0;     ///< size in the text [byte]
  std::string source;         ///< as written in the file, shortened, for messages
  bool representable = true;  ///< false for a number outside its type's range
  bool boolean = false;
  std::int64_t integer = 0;
  double number = 0;  ///< also for an integer
  std::string string;
  std::vector<Value> elements;  ///< of an array
  std::vector<Member> members;  ///< of a table, sorted by name

  const Value* find(const std::string& name) const;  ///< the table's member, or null
  bool operator==(const Value& other) const;         ///< equal content, regardless of location
};

struct Member {
  std::string name;
  Value value;
  bool operator==(const Member& other) const = default;
};

/// The value at a path such as "specimen.notch[0].depth" below `root`; null if there is none.
const Value* find_path(const Value& root, const std::string& path);

/// True unless the value is or has a table or a date.
bool is_plain(const Value& value);

/// The value in TOML syntax: text in quotes, arrays in brackets. @pre is_plain(value)
std::string to_toml(const Value& value);

/// The text is not valid TOML.
class SyntaxError : public std::runtime_error {
public:
  SyntaxError(int line, const std::string& message) : std::runtime_error(message), line_(line) {}
  int line() const { return line_; }

private:
  int line_;
};

/// More than any input needs. toml11's time is quadratic in the size: about a second for this one.
inline constexpr std::size_t max_text_size = std::size_t{1} << 17;

/// Rejects text unsuitable for the TOML parser: control bytes, invalid UTF-8, no content at all, or nesting
/// so deep that its recursion would exhaust the stack.
/// @throws SyntaxError
void check_text(const std::string& text);

/// The document's root table.
/// @throws SyntaxError when the text is not valid TOML
Value parse_document(const std::string& text);

/// One line of printable text from any text, at most `length` bytes.
std::string shortened(const std::string& text, std::size_t length = 60);

/// "a string", "a table", ... for messages.
const char* describe(ValueKind kind);

}  // namespace crackle::input
