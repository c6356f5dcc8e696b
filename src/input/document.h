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

/// One value of a TOML document with the place it stands at.
struct Value {
  ValueKind kind = ValueKind::table;
  int line = 1;
  std::size_t column = 1;     ///< of its first byte in that line
  std::size_t length = 0;     ///< bytes that it takes in the text
  std::string source;         ///< as written in the file, shortened, for messages
  bool representable = true;  ///< false for a number beyond its type's range
  bool boolean = false;
  std::int64_t integer = 0;
  double number = 0;  ///< of an integer too
  std::string string;
  std::vector<Value> elements;  ///< of an array
  std::vector<Member> members;  ///< of a table, sorted by name

  const Value* find(const std::string& name) const;  ///< the table's member, or null
  bool operator==(const Value& other) const;         ///< the same content, wherever it stands
};

struct Member {
  std::string name;
  Value value;
  bool operator==(const Member& other) const = default;
};

/// The value at a path such as "specimen.notch[0].depth" below `root`, or null where there is none.
const Value* find_path(const Value& root, const std::string& path);

/// The value as a document has it: text in quotes, arrays in brackets. @pre no table and no date
std::string to_toml(const Value& value);

/// The text is not TOML.
class SyntaxError : public std::runtime_error {
public:
  SyntaxError(int line, const std::string& message) : std::runtime_error(message), line_(line) {}
  int line() const { return line_; }

private:
  int line_;
};

/// More than any input needs. toml11's time grows with the square of the size: a second for this one.
inline constexpr std::size_t max_text_size = std::size_t{1} << 17;

/// What the TOML parser must not be given: bytes that are no text, invalid UTF-8, no content at all, or
/// nesting so deep that its recursion would exhaust the stack.
/// @throws SyntaxError
void check_text(const std::string& text);

/// The document's root table.
/// @throws SyntaxError for anything that is not a text or not TOML
Value parse_document(const std::string& text);

/// One line of printable text out of any text, at most `length` bytes.
std::string shortened(const std::string& text, std::size_t length = 60);

/// "a string", "a table", ... for messages.
const char* describe(ValueKind kind);

}  // namespace crackle::input
