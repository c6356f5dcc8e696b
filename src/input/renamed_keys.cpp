// SPDX-License-Identifier: GPL-3.0-or-later
#include "renamed_keys.h"

#include "settings.h"

#include <algorithm>

namespace crackle::input {

namespace {

std::string_view table_of(std::string_view key) {
  return key.substr(0, key.rfind('.'));
}

std::string_view last_name(std::string_view key) {
  return key.substr(key.rfind('.') + 1);
}

void note(const RenamedKey& key, const std::string& place, int line, Findings& findings) {
  findings.note(place, line,
                fmt::format("the name {} is now {}; the next version does not accept the earlier one",
                            key.earlier, key.current));
}

void remove(Value& root, const RenamedKey& key) {
  const auto table = std::ranges::find(root.members, table_of(key.earlier), &Member::name);
  std::erase_if(table->value.members, [&](const Member& m) { return m.name == last_name(key.earlier); });
}

}  // namespace

std::string current_name(const std::string& key, const std::string& place, int line, Findings& findings) {
  const auto* const renamed = std::ranges::find(renamed_keys, key, &RenamedKey::earlier);
  if (renamed == renamed_keys.end()) return key;
  note(*renamed, place, line, findings);
  return std::string(renamed->current);
}

std::string with_earlier_name(std::string line) {
  for (const RenamedKey& key : renamed_keys)
    if (line.starts_with(fmt::format("{} =", key.current))) line.replace(0, key.current.size(), key.earlier);
  return line;
}

std::string with_current_names(std::string text, Value& root, Findings& findings) {
  for (const RenamedKey& key : renamed_keys) {
    const std::string earlier(key.earlier);
    const Value* const value = find_path(root, earlier);
    if (value == nullptr) continue;
    const int line = value->line;
    const std::string_view name = last_name(key.earlier);
    if (find_path(root, std::string(key.current)) != nullptr) {
      findings.report(earlier, line,
                      fmt::format("this is the earlier name of {}, which is given too; give {} only",
                                  key.current, last_name(key.current)));
      remove(root, key);
      continue;
    }
    note(key, earlier, line, findings);
    // The key stands before its value in the same line.
    const std::size_t at = text.rfind(name, extent_of(text, *value).first - name.size());
    text.replace(at, name.size(), last_name(key.current));
    root = parse_document(text);
    if (find_path(root, earlier) != nullptr || find_path(root, std::string(key.current)) == nullptr)
      throw SyntaxError(line, fmt::format("write {} instead of {}", key.current, key.earlier));
  }
  return text;
}

}  // namespace crackle::input
