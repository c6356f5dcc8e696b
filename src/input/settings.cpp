// SPDX-License-Identifier: GPL-3.0-or-later
// Replaces values in an input and in its text.

#include "settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

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

/// Insertion into a table: an inline one, behind its header, or before its first dotted key.
std::optional<Change> added_to(const std::string& text, const Value& table, const std::string& entry) {
  const std::size_t begin = extent_of(text, table).first;
  if (table.kind != ValueKind::table || begin >= text.size()) return {};
  if (text[begin] == '{')
    return Change{begin + 1, begin + 1, fmt::format(" {}{}", entry, table.members.empty() ? " " : ",")};
  if (text[begin] == '[') {
    const std::size_t next = end_of_line(text, begin);
    return Change{next, next, fmt::format("{}{}\n", text[next - 1] == '\n' ? "" : "\n", entry)};
  }
  for (const Member& member : table.members) {
    const std::size_t start = start_of_line(text, member.value.line);
    const std::size_t end = std::min(text.find('=', start), text.size());
    const std::size_t name = text.rfind(member.name, end);
    if (name == std::string::npos || name <= start || text[name - 1] != '.') continue;
    return Change{start, start, fmt::format("{}{}\n", text.substr(start, name - start), entry)};
  }
  return {};
}

[[noreturn]] void refuse(const Setting& setting, const std::string& reason) {
  throw InputError({fmt::format("{} = {}: {}", setting.key, setting.value, reason)});
}

std::string apply(std::string text, std::vector<Change> changes) {
  std::ranges::stable_sort(changes, std::greater(), &Change::begin);
  for (const auto& [begin, end, inserted] : changes) text.replace(begin, end - begin, inserted);
  return text;
}

/// The positions of changes are the parser's, and a table can be written in many ways.
bool is_text_of(const Value& document, const std::string& text) {
  try {
    return parse_document(text) == document;
  } catch (const SyntaxError&) {
    return false;
  }
}

constexpr const char* no_place = "the key cannot be inserted into the input; add it by hand";

/// The text with a missing key, in its nearest enclosing table in the form that this has, or at the end with
/// its own header.
std::string with_added(const std::string& text, const Setting& setting) {
  const Value root = parse_document(text), wanted = with_settings(root, {setting});
  const auto last_dot = setting.key.rfind('.');
  if (last_dot == std::string::npos) refuse(setting, no_place);
  for (auto dot = last_dot; dot != std::string::npos && dot > 0; dot = setting.key.rfind('.', dot - 1)) {
    const Value* const table = find_path(root, setting.key.substr(0, dot));
    const std::string entry = fmt::format("{} = {}", setting.key.substr(dot + 1), setting.value);
    const auto way = table != nullptr ? added_to(text, *table, entry) : std::nullopt;
    if (std::string result = way ? apply(text, {*way}) : ""; is_text_of(wanted, result)) return result;
  }
  std::string result = fmt::format("{}\n[{}]\n{} = {}\n", text, setting.key.substr(0, last_dot),
                                   setting.key.substr(last_dot + 1), setting.value);
  if (!is_text_of(wanted, result)) refuse(setting, no_place);
  return result;
}

Value* find_path(Value& root, const std::string& path) {
  return const_cast<Value*>(find_path(std::as_const(root), path));
}

/// Adds a missing key to a document, with the tables around it.
/// @return false if it is not in tables
bool add(Value& root, const std::string& path, Value value) {
  const auto dot = path.rfind('.');
  const std::string name = path.substr(dot + 1), around = dot == std::string::npos ? "" : path.substr(0, dot);
  if (find_path(root, around) == nullptr && !add(root, around, Value{})) return false;
  Value& table = *find_path(root, around);
  if (table.kind != ValueKind::table || name.find('[') != std::string::npos) return false;
  const auto after = std::ranges::upper_bound(table.members, name, {}, &Member::name);
  table.members.insert(after, {name, std::move(value)});
  return true;
}

}  // namespace

std::pair<std::size_t, std::size_t> extent_of(const std::string& text, const Value& value) {
  const std::size_t begin = std::min(start_of_line(text, value.line) + value.column - 1, text.size());
  return {begin, std::min(begin + value.length, text.size())};
}

Value with_settings(Value root, const std::vector<Setting>& settings) {
  for (const Setting& setting : settings) {
    Value value = *parse_document("value = " + setting.value).find("value");
    Value* const found = find_path(root, setting.key);
    if (found == nullptr) {
      if (!add(root, setting.key, std::move(value))) refuse(setting, no_place);
    } else {
      value.line = found->line;
      *found = std::move(value);
    }
  }
  // One may have replaced the table of another.
  for (const Setting& setting : settings)
    if (find_path(root, setting.key) == nullptr) refuse(setting, "another value replaces its table");
  return root;
}

std::string with_settings(const std::string& text, const std::vector<Setting>& settings) {
  const Value root = parse_document(text), wanted = with_settings(root, settings);
  std::vector<Change> changes;
  std::vector<Setting> missing;
  for (const Setting& setting : settings) {
    if (const Value* const value = find_path(root, setting.key)) {
      const auto [begin, end] = extent_of(text, *value);
      changes.push_back({begin, end, setting.value});
    } else {
      missing.push_back(setting);
    }
  }
  std::string result = apply(text, changes);
  for (const Setting& setting : missing) result = with_added(result, setting);
  if (!is_text_of(wanted, result)) refuse(settings.front(), "the value cannot be replaced");
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
  Value root = parse_document(text);
  const Value* const tables = root.find(name);
  if (tables == nullptr) return text;
  std::vector<Change> changes;
  for (const Value& table : tables->elements) {
    std::size_t last = 0;
    for (const Member& member : table.members) last = std::max(last, extent_of(text, member.value).second);
    changes.push_back({extent_of(text, table).first, end_of_line(text, last), {}});
  }
  std::string result = apply(text, changes);
  std::erase_if(root.members, [&](const Member& member) { return member.name == name; });
  if (!is_text_of(root, result))
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
