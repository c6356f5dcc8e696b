// SPDX-License-Identifier: GPL-3.0-or-later
// Replaces values in the text of an input.
#include "crackle/common/whole_number.h"
#include "crackle/input/reader.h"

#include "document.h"
#include "settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <tuple>
#include <vector>

namespace crackle::input {

namespace {

/// A range of bytes of a text and its replacement.
struct Change {
  std::size_t begin;
  std::size_t end;
  std::string text;
};

/// Byte offset of a line; lines are counted from 1.
std::size_t start_of_line(const std::string& text, int line) {
  std::size_t start = 0;
  for (int i = 1; i < line && start < text.size(); ++i)
    start = std::min(text.find('\n', start), text.size() - 1) + 1;
  return start;
}

std::size_t end_of_line(const std::string& text, std::size_t at) {
  const std::size_t end = text.find('\n', at);
  return end == std::string::npos ? text.size() : end + 1;
}

/// Byte offset after the header line of a table: "[fracture]", the second "[[boundary]]" for "boundary[1]",
/// or the first "[material.map]" after the second "[[material]]" for "material[1].map". Empty if the text has
/// no such line.
std::optional<std::size_t> behind_header(const std::string& text, const std::string& path,
                                         std::size_t from = 0) {
  const auto bracket = path.find('[');
  const auto end = path.find(']');
  std::size_t count = 0;
  std::string header = fmt::format("[{}]", path);
  if (bracket != std::string::npos) {
    const std::string name = path.substr(0, bracket);
    if (end != path.size() - 1) {
      const auto whole = behind_header(text, path.substr(0, end + 1));
      if (!whole || path.find('[', end) != std::string::npos) return {};
      const auto part = behind_header(text, name + path.substr(end + 1), *whole);
      const auto next = behind_header(text, fmt::format("{}[0]", name), *whole);
      return part && next && *next < *part ? std::nullopt : part;
    }
    header = fmt::format("[[{}]]", name);
    const auto number =
        whole_number<std::size_t>(std::string_view(path).substr(bracket + 1, path.size() - bracket - 2));
    if (!number) return {};
    count = *number;
  }
  for (std::size_t start = from; start < text.size(); start = end_of_line(text, start)) {
    const std::size_t first = text.find_first_not_of(" \t", start);
    if (first == std::string::npos || text.compare(first, header.size(), header) != 0) continue;
    if (count-- == 0) return end_of_line(text, start);
  }
  return {};
}

/// Insertion into an inline table: "mesh = { spacing = "1 mm" }".
std::optional<Change> added_inline(const std::string& text, const Value& table, const std::string& entry) {
  const std::size_t begin = extent_of(text, table).first;
  if (table.kind != ValueKind::table || begin >= text.size() || text[begin] != '{') return {};
  return Change{begin + 1, begin + 1, fmt::format(" {}{}", entry, table.members.empty() ? " " : ",")};
}

/// Insertion before the first dotted key of a table: "mesh.spacing = "1 mm"".
std::optional<Change> added_dotted(const std::string& text, const Value& table, const std::string& entry) {
  for (const Member& member : table.members) {
    const std::size_t start = start_of_line(text, member.value.line);
    const std::size_t end = std::min(text.find('=', start), text.size());
    const std::size_t name = text.rfind(member.name, end);
    if (name == std::string::npos || name <= start || text[name - 1] != '.') continue;
    return Change{start, start, fmt::format("{}{}\n", text.substr(start, name - start), entry)};
  }
  return {};
}

/// Ways to insert a missing key, the most natural first: into its nearest enclosing table in the form that
/// this has, or at the end with its own header.
std::vector<Change> additions(const std::string& text, const Value& root, const Setting& setting) {
  std::vector<Change> ways;
  const auto add = [&](const std::optional<Change>& way) {
    if (way) ways.push_back(*way);
  };
  for (auto dot = setting.key.rfind('.'); dot != std::string::npos && dot > 0;
       dot = setting.key.rfind('.', dot - 1)) {
    const std::string path = setting.key.substr(0, dot);
    const std::string entry = fmt::format("{} = {}", setting.key.substr(dot + 1), setting.value);
    if (const auto place = behind_header(text, path)) {
      const char* const before = *place > 0 && text[*place - 1] != '\n' ? "\n" : "";
      ways.push_back({*place, *place, fmt::format("{}{}\n", before, entry)});
    }
    if (const Value* const table = find_path(root, path)) {
      add(added_inline(text, *table, entry));
      add(added_dotted(text, *table, entry));
    }
  }
  if (const auto dot = setting.key.rfind('.'); dot != std::string::npos)
    ways.push_back({text.size(), text.size(),
                    fmt::format("\n[{}]\n{} = {}\n", setting.key.substr(0, dot), setting.key.substr(dot + 1),
                                setting.value)});
  return ways;
}

[[noreturn]] void refuse(const Setting& setting, const std::string& reason) {
  throw InputError({fmt::format("{} = {}: {}", setting.key, setting.value, reason)});
}

std::string apply(std::string text, std::vector<Change> changes) {
  std::ranges::stable_sort(changes, std::greater(), &Change::begin);
  for (const auto& [begin, end, inserted] : changes) text.replace(begin, end - begin, inserted);
  return text;
}

/// The first setting that a text does not have, or all of them if it is no TOML; null if it has all. The
/// positions of changes are the parser's, and a table can be written in many ways.
const Setting* first_not_in(const std::string& text, const std::vector<Setting>& settings) {
  try {
    const Value root = parse_document(text);
    for (const Setting& setting : settings) {
      const Value* const found = find_path(root, setting.key);
      const Value wanted = parse_document("value = " + setting.value);
      if (found == nullptr || *found != *wanted.find("value")) return &setting;
    }
    return nullptr;
  } catch (const SyntaxError&) {
    return settings.empty() ? nullptr : &settings.front();
  }
}

std::string with_added(const std::string& text, const Setting& setting) {
  for (const Change& way : additions(text, parse_document(text), setting)) {
    std::string result = apply(text, {way});
    if (first_not_in(result, {setting}) == nullptr) return result;
  }
  refuse(setting, "the key cannot be inserted into the input; add it by hand");
}

}  // namespace

std::pair<std::size_t, std::size_t> extent_of(const std::string& text, const Value& value) {
  const std::size_t begin = std::min(start_of_line(text, value.line) + value.column - 1, text.size());
  return {begin, std::min(begin + value.length, text.size())};
}

std::string with_settings(const std::string& text, const std::vector<Setting>& settings) {
  const Value root = parse_document(text);
  std::vector<Change> changes;
  std::vector<Setting> replaced, missing;
  for (const Setting& setting : settings) {
    const Value* const value = find_path(root, setting.key);
    (value == nullptr ? missing : replaced).push_back(setting);
    if (value == nullptr) continue;
    const auto [begin, end] = extent_of(text, *value);
    changes.push_back({begin, end, setting.value});
  }
  std::string result = apply(text, changes);
  if (const Setting* const lost = first_not_in(result, replaced))
    refuse(*lost, "the value cannot be replaced");
  for (const Setting& setting : missing) result = with_added(result, setting);
  // A value may have replaced the table of another.
  if (const Setting* const lost = first_not_in(result, settings))
    refuse(*lost, "the value cannot be replaced");
  return result;
}

std::string completed(const std::string& text, std::vector<Setting> settings) {
  try {
    const Value root = parse_document(text);
    std::erase_if(settings, [&](const Setting& setting) { return find_path(root, setting.key) != nullptr; });
  } catch (const SyntaxError&) {
    return text;  // reading it reports the error
  }
  return settings.empty() ? text : with_settings(text, settings);
}

std::string without_tables(const std::string& text, const std::string& name) {
  const Value root = parse_document(text);
  const Value* const tables = root.find(name);
  if (tables == nullptr) return text;
  std::vector<Change> changes;
  for (const Value& table : tables->elements) {
    std::size_t first = text.size(), last = 0;
    for (const Member& member : table.members) {
      const auto [begin, end] = extent_of(text, member.value);
      first = std::min(first, begin);
      last = std::max(last, end);
    }
    const std::size_t header = text.rfind("[[" + name + "]]", first);
    if (header != std::string::npos) changes.push_back({header, end_of_line(text, last), {}});
  }
  std::string result = apply(text, changes);
  Value expected = root;
  std::erase_if(expected.members, [&](const Member& member) { return member.name == name; });
  if (parse_document(result) != expected)
    throw InputError({fmt::format(
        "{0}: cannot be separated from the rest of the input; write it as a separate table [[{0}]]", name)});
  return result;
}

std::string to_string(const std::vector<Setting>& settings) {
  std::vector<std::string> items;
  for (const auto& [key, value] : settings) items.push_back(fmt::format("{} = {}", key, value));
  return fmt::format("{}", fmt::join(items, ", "));
}

}  // namespace crackle::input
