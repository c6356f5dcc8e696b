// SPDX-License-Identifier: GPL-3.0-or-later
#include "document.h"

#include "common/printable.h"
#include "common/whole_number.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <boost/locale/utf.hpp>
#include <charconv>
#include <iterator>
#include <map>
#include <sstream>
#include <string_view>
#include <toml.hpp>

namespace crackle::input {

namespace {

// Differences between toml11 versions 3 and 4.
#if TOML11_VERSION_MAJOR >= 4
struct SortedTables : toml::type_config {
  template <class Key, class Element>
  using table_type = std::map<Key, Element>;
};
using TomlValue = toml::basic_value<SortedTables>;

TomlValue parse(std::istream& stream) {
  return toml::parse<SortedTables>(stream, "input");
}
std::size_t line_of(const toml::source_location& place) {
  return place.first_line_number();
}
std::size_t column_of(const toml::source_location& place) {
  return place.first_column_number();
}
std::size_t length_of(const toml::source_location& place) {
  return place.length();
}
const std::string& string_of(const TomlValue& value) {
  return value.as_string();
}
toml::source_location place_of(const toml::syntax_error& error) {
  return error.errors().at(0).locations().at(0).first;
}
#else
using TomlValue = toml::basic_value<toml::discard_comments, std::map, std::vector>;

TomlValue parse(std::istream& stream) {
  return toml::parse<toml::discard_comments, std::map, std::vector>(stream, "input");
}
std::size_t line_of(const toml::source_location& place) {
  return place.line();
}
std::size_t column_of(const toml::source_location& place) {
  return place.column();
}
std::size_t length_of(const toml::source_location& place) {
  return place.region();
}
const std::string& string_of(const TomlValue& value) {
  return value.as_string().str;
}
const toml::source_location& place_of(const toml::syntax_error& error) {
  return error.location();
}
#endif

/// toml11 silently clamps numbers that are too large, so their source is parsed again.
bool fits(std::string source, ValueKind kind) {
  source.erase(std::remove(source.begin(), source.end(), '_'), source.end());
  const char* begin = source.data();
  const char* const end = begin + source.size();
  if (begin != end && *begin == '+') ++begin;
  if (kind == ValueKind::number) {
    double number = 0;
    return std::from_chars(begin, end, number).ec == std::errc{};
  }
  int base = 10;
  if (end - begin > 2 && begin[0] == '0') {
    base = begin[1] == 'x' ? 16 : begin[1] == 'o' ? 8 : begin[1] == 'b' ? 2 : 10;
    if (base != 10) begin += 2;
  }
  std::int64_t integer = 0;
  return std::from_chars(begin, end, integer, base).ec == std::errc{};
}

/// The lines of an input. (The source lines provided by toml11 4 are shortened for display.)
class SourceLines {
public:
  explicit SourceLines(const std::string& text) {
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines_.push_back(std::move(line));
  }

  /// The line in which a location begins; empty if there is none.
  std::string_view line(const toml::source_location& place) const {
    const std::size_t number = line_of(place);
    return number >= 1 && number <= lines_.size() ? lines_[number - 1] : std::string_view();
  }

  /// The source at a location, up to the end of its first line.
  std::string source(const toml::source_location& place) const {
    const std::string_view whole = line(place);
    const std::size_t start = column_of(place) > 0 ? column_of(place) - 1 : 0;
    return start < whole.size() ? std::string(whole.substr(start, length_of(place))) : std::string();
  }

private:
  std::vector<std::string> lines_;
};

Value convert(const TomlValue& toml_value, const SourceLines& lines) {
  Value value;
  const toml::source_location place = toml_value.location();
  value.line = static_cast<int>(line_of(place));
  value.column = column_of(place);
  value.length = length_of(place);
  const std::string source = lines.source(place);
  value.source = shortened(source);
  switch (toml_value.type()) {
    case toml::value_t::boolean:
      value.kind = ValueKind::boolean;
      value.boolean = toml_value.as_boolean();
      break;
    case toml::value_t::integer:
      value.kind = ValueKind::integer;
      value.integer = toml_value.as_integer();
      value.number = static_cast<double>(value.integer);
      value.representable = fits(source, value.kind);
      break;
    case toml::value_t::floating:
      value.kind = ValueKind::number;
      value.number = toml_value.as_floating();
      value.representable = fits(source, value.kind);
      break;
    case toml::value_t::string:
      value.kind = ValueKind::string;
      value.string = string_of(toml_value);
      value.source = '"' + shortened(value.string) + '"';
      break;
    case toml::value_t::array:
      value.kind = ValueKind::array;
      for (const TomlValue& element : toml_value.as_array())
        value.elements.push_back(convert(element, lines));
      break;
    case toml::value_t::table:
      value.kind = ValueKind::table;
      for (const auto& [name, member] : toml_value.as_table()) {
        value.members.push_back({name, convert(member, lines)});
      }
      break;
    case toml::value_t::empty:
    case toml::value_t::offset_datetime:
    case toml::value_t::local_datetime:
    case toml::value_t::local_date:
    case toml::value_t::local_time:
      value.kind = ValueKind::date;
      break;
  }
  return value;
}

bool is_unquoted_quantity(const std::string& line) {
  const auto equals = line.find('=');
  if (equals == std::string::npos) return false;
  const auto start = line.find_first_not_of(" \t", equals + 1);
  if (start == std::string::npos || !(std::isdigit(static_cast<unsigned char>(line[start])))) return false;
  const auto end = line.find_first_not_of("0123456789.eE+-_", start);
  if (end == std::string::npos) return false;
  const auto unit = line.find_first_not_of(" \t", end);
  return unit != std::string::npos && std::isalpha(static_cast<unsigned char>(line[unit]));
}

/// toml11 explains an error on some ten lines: a title, the source line, and remarks after "^---".
std::string condensed(const std::string& explanation, const std::string& line) {
  std::istringstream lines(explanation);
  std::string text;
  std::getline(lines, text);
  for (const std::string_view prefix : {"[error] ", "toml::"})
    if (text.starts_with(prefix)) text.erase(0, prefix.size());
  if (const auto colon = text.find(": "); colon != std::string::npos && text.find(' ') > colon) {
    text.erase(0, colon + 2);
  }
  std::string remark;
  for (std::string next; std::getline(lines, next);) {
    if (const auto arrow = next.find("^---"); arrow != std::string::npos) remark = next.substr(arrow + 4);
  }
  remark.erase(0, remark.find_first_not_of(' '));
  if (!remark.empty() && remark != "here" && remark.find("value already exists") == std::string::npos) {
    text += ", " + remark;
  }
  if (!text.empty() && text.back() == '.') text.pop_back();
  text = shortened(text, 160);
  const auto start = line.find_first_not_of(" \t");
  if (start != std::string::npos) {
    const auto end = line.find_last_not_of(" \t\r") + 1;
    text += fmt::format(", in: {}", shortened(line.substr(start, end - start)));
  }
  if (is_unquoted_quantity(line)) text += " (a value with a unit must be in quotes, such as \"1.0 mm\")";
  return text;
}

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

const Value* Value::find(const std::string& name) const {
  const auto member = std::ranges::find(members, name, &Member::name);
  return member == members.end() ? nullptr : &member->value;
}

bool Value::operator==(const Value& other) const {
  return kind == other.kind && boolean == other.boolean && integer == other.integer &&
         number == other.number && string == other.string && elements == other.elements &&
         members == other.members;
}

const Value* find_path(const Value& root, const std::string& path) {
  const Value* value = &root;
  for (std::size_t start = 0; start < path.size() && value != nullptr;) {
    if (path[start] == '.') {
      ++start;
    } else if (path[start] == '[') {
      const std::size_t end = std::min(path.find(']', start), path.size());
      const auto number =
          whole_number<std::size_t>(std::string_view(path).substr(start + 1, end - start - 1));
      const bool is_there = value->kind == ValueKind::array && number && *number < value->elements.size();
      value = is_there ? &value->elements[*number] : nullptr;
      start = end + 1;
    } else {
      const std::size_t end = std::min(path.find_first_of(".[", start), path.size());
      value = value->find(path.substr(start, end - start));
      start = end;
    }
  }
  return value;
}

bool is_plain(const Value& value) {
  return value.kind != ValueKind::table && value.kind != ValueKind::date &&
         std::ranges::all_of(value.elements, is_plain);
}

std::string to_toml(const Value& value) {
  switch (value.kind) {
    case ValueKind::boolean:
      return value.boolean ? "true" : "false";
    case ValueKind::integer:
      return std::to_string(value.integer);
    case ValueKind::number: {
      const std::string text = fmt::format("{}", value.number);
      return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
    }
    case ValueKind::string: {
      std::string text = "\"";
      for (const char c : value.string) {
        if (c == '"' || c == '\\')
          text += fmt::format("\\{}", c);
        else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
          text += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
        else
          text += c;
      }
      return text + '"';
    }
    case ValueKind::array: {
      std::vector<std::string> elements;
      for (const Value& element : value.elements) elements.push_back(to_toml(element));
      return fmt::format("[{}]", fmt::join(elements, ", "));
    }
    case ValueKind::table:
    case ValueKind::date:
      break;
  }
  throw std::logic_error("only plain values and arrays of them can be written");
}

/// In TOML [[random.flaws]] belongs to the [[random]] before it, or to a table if there is none. Here all of
/// them are a member of the array beside its elements.
Value with_flaws_beside_random(Value root) {
  const auto random = std::ranges::find(root.members, "random", &Member::name);
  if (random == root.members.end()) return root;
  Value flaws;
  flaws.kind = ValueKind::array;
  const auto take = [&](Value& from) {
    std::erase_if(from.members, [&](Member& member) {
      if (member.name != "flaws" || member.value.kind != ValueKind::array) return false;
      if (flaws.elements.empty()) flaws.line = member.value.line;
      std::ranges::move(member.value.elements, std::back_inserter(flaws.elements));
      return true;
    });
  };
  Value& list = random->value;
  take(list);
  for (Value& element : list.elements) take(element);
  if (flaws.elements.empty()) return root;
  if (list.members.empty()) list.kind = ValueKind::array;
  list.members.push_back({"flaws", std::move(flaws)});
  return root;
}

Value parse_document(const std::string& text) {
  check_text(text);
  const SourceLines lines(text);
  std::istringstream stream(text);
  try {
    return with_flaws_beside_random(convert(parse(stream), lines));
  } catch (const toml::syntax_error& error) {
    const toml::source_location place = place_of(error);
    throw SyntaxError(static_cast<int>(line_of(place)),
                      "syntax error: " + condensed(error.what(), std::string(lines.line(place))));
  } catch (const SyntaxError&) {
    throw;
  } catch (const std::exception& error) {
    throw SyntaxError(1, "syntax error: " + condensed(error.what(), ""));
  }
}

std::string shortened(const std::string& text, std::size_t length) {
  std::string result = printable(text);
  for (char& c : result)
    if (c == '\n' || c == '\t') c = ' ';
  if (result.size() <= length) return result;
  result.resize(length);
  // Do not split a UTF-8 sequence.
  while (!result.empty() && (static_cast<unsigned char>(result.back()) & 0xc0) == 0x80) result.pop_back();
  if (!result.empty() && static_cast<unsigned char>(result.back()) >= 0x80) result.pop_back();
  return result + "...";
}

const char* describe(ValueKind kind) {
  constexpr std::array names{"a boolean", "a plain number", "a plain number", "a string",
                             "an array",  "a table",        "a date"};
  return names[static_cast<std::size_t>(kind)];
}

void check_text(const std::string& text) {
  if (text.size() > max_text_size) {
    throw SyntaxError(1, fmt::format("longer than {} bytes; give an input file in TOML", max_text_size));
  }
  check_characters(text);
  check_nesting(text);
}

}  // namespace crackle::input
