// SPDX-License-Identifier: GPL-3.0-or-later
#include "input/reader.h"

#include "document.h"
#include "schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace crackle::input {

namespace {

constexpr std::size_t comment_width = 110;

/// Lines of at most comment_width characters that start with "# ".
std::string comment(const std::string& text) {
  std::string result, line = "#";
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (line.size() + 1 + word.size() > comment_width) {
      result += line + "\n";
      line.assign(1, '#');
    }
    line += " " + word;
  }
  return result + line + "\n";
}

/// A possible value of the key: its default, or one taken from the description of accepted values.
std::string example_of(const Requirement& requirement, const std::string& accepted) {
  if (!requirement.fallback.empty()) return requirement.fallback;
  if (accepted == "true") return accepted;
  constexpr std::string_view such_as = "such as ";
  if (const auto at = accepted.find(such_as); at != std::string::npos) {
    const std::string example = accepted.substr(at + such_as.size());
    // Up to the closing bracket or quotation mark.
    const char close = example[0] == '[' ? ']' : example[0] == '"' ? '"' : ' ';
    int depth = 0;
    for (std::size_t i = 0; i < example.size(); ++i) {
      if (close == ']') depth += (example[i] == '[' ? 1 : 0) - (example[i] == ']' ? 1 : 0);
      const bool ends = close == ']' ? depth == 0 : i > 0 && example[i] == close;
      if (ends) return example.substr(0, close == ' ' ? i : i + 1);
    }
    return example;
  }
  if (const auto begin = accepted.find('"'); begin != std::string::npos)
    return accepted.substr(begin, accepted.find('"', begin + 1) - begin + 1);
  if (accepted.starts_with("name of a")) return "\"points.txt\"";
  // One end of a range of numbers.
  for (const std::string_view before : {"from ", "up to "})
    if (const auto at = accepted.find(before); at != std::string::npos)
      return accepted.substr(at + before.size(), accepted.find(' ', at + before.size()) - at - before.size());
  return {};
}

std::string explanation(const Requirement& requirement, const std::string& accepted,
                        const std::string& help) {
  const std::string& unset = requirement.unset;
  return comment(fmt::format("{}: {}{}", help, accepted, unset.empty() ? unset : "; default: " + unset));
}

std::string commented_out(const Key& key) {
  return commented_out(key.name, key.requirement, key.accepted, key.help);
}

/// The lines of a table with an explanation before each key.
std::string explained(const std::string& block, const Table& table) {
  std::string result;
  std::istringstream lines(block);
  for (std::string line; std::getline(lines, line);) {
    const std::string name = line.substr(0, line.find_first_of(" ="));
    const auto key = std::ranges::find(table.keys, name, &Key::name);
    if (key != table.keys.end()) result += explanation(key->requirement, key->accepted, key->help);
    result += line + "\n";
  }
  return result;
}

/// The first value of this path in a document, or null.
const Value* first_value(const Value& root, const std::string& path) {
  const Value* value = &root;
  std::istringstream names(path);
  for (std::string name; value != nullptr && std::getline(names, name, '.');) {
    value = value->find(name);
    if (value != nullptr && value->kind == ValueKind::array)
      value = value->elements.empty() ? nullptr : &value->elements.front();
  }
  return value;
}

/// The lines of an input by table; those before the first table under "".
std::map<std::string, std::vector<std::string>> blocks_of(const std::string& text) {
  std::map<std::string, std::vector<std::string>> blocks;
  std::string* block = &blocks[""].emplace_back();
  std::istringstream lines(text);
  std::string list;  // the array of tables whose last one is open
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('[')) {
      const auto begin = line.find_first_not_of('[');
      const std::string path = line.substr(begin, line.find(']') - begin);
      // A table inside one of an array belongs to the last of these.
      if (begin == 2) list = path;
      if (begin == 2 || list.empty() || !path.starts_with(list + ".")) block = &blocks[path].emplace_back();
    }
    *block += line + "\n";
  }
  return blocks;
}

std::string without_blank_end(std::string text) {
  while (text.ends_with("\n\n")) text.pop_back();
  return text;
}

}  // namespace

std::string commented_out(const std::string& name, const Requirement& requirement,
                          const std::string& accepted, const std::string& help) {
  return explanation(requirement, accepted, help) +
         fmt::format("#{} = {}\n", name, example_of(requirement, accepted));
}

std::string annotated(const std::string& text) {
  const Value root = parse_document(text);
  auto blocks = blocks_of(text);
  std::string result = blocks[""].front();
  for (const Table& table : schema()) {
    const auto& present = blocks[table.path];
    result += fmt::format("\n# ---- {}: {}\n", header_of(table), table.help);
    if (present.empty()) result += fmt::format("#{}\n", header_of(table));
    for (std::size_t i = 0; i < present.size(); ++i) {
      const std::string block = without_blank_end(present[i]);
      result += i == 0 ? explained(block, table) : block;
      if (i > 0) continue;
      const Value* const given = first_value(root, table.path);
      for (const Key& key : table.keys)
        if (given == nullptr || first_value(*given, key.name) == nullptr) result += commented_out(key);
    }
    if (present.empty())
      for (const Key& key : table.keys) result += commented_out(key);
  }
  return result;
}

}  // namespace crackle::input
