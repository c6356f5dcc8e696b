// SPDX-License-Identifier: GPL-3.0-or-later
#include "schema.h"

#include "common/nearest_name.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <string>
#include <vector>

namespace crackle::input {

namespace {

/// A full path of the schema without indices ("boundary.region.y") and its kind.
struct Place {
  enum class Form { key, table, tables, either };
  std::string path;
  Form form;
};

std::vector<Place> places_in(const std::vector<KnownTable>& tables) {
  std::vector<Place> places;
  const auto add = [&](const std::string& path, Place::Form form) {
    const auto known = std::ranges::find(places, path, &Place::path);
    if (known == places.end())
      places.push_back({path, form});
    else if (form == Place::Form::tables)
      known->form = form;
  };
  for (const KnownTable& table : tables) {
    for (auto dot = table.path.find('.'); dot != std::string::npos; dot = table.path.find('.', dot + 1)) {
      add(table.path.substr(0, dot), Place::Form::table);
    }
    const std::string inside = table.path.empty() ? "" : table.path + ".";
    if (!inside.empty())
      add(table.path, table.occurrence == Occurrence::many           ? Place::Form::tables
                      : table.occurrence == Occurrence::once_or_many ? Place::Form::either
                                                                     : Place::Form::table);
    for (const std::string& key : table.keys) {
      const auto dot = key.find('.');
      if (dot != std::string::npos) add(inside + key.substr(0, dot), Place::Form::table);
      add(inside + key, Place::Form::key);
    }
  }
  return places;
}

std::string last_name(const std::string& path) {
  return path.substr(path.rfind('.') + 1);
}

std::string parent(const std::string& path) {
  const auto dot = path.rfind('.');
  return dot == std::string::npos ? "" : path.substr(0, dot);
}

/// Without case and punctuation: "kic" of "K_Ic".
std::string letters_of(const std::string& name) {
  std::string letters;
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      letters += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return letters;
}

/// Full paths of the keys of which a name is a synonym, or which it only writes in another way.
std::vector<std::string> keys_called(const std::string& name, const std::vector<KnownTable>& tables) {
  std::vector<std::string> paths;
  const std::string letters = letters_of(name);
  for (const KnownTable& table : tables) {
    const std::string inside = table.path.empty() ? "" : table.path + ".";
    for (const std::string& key : table.keys)
      if (letters_of(key) == letters) paths.push_back(inside + key);
    for (const auto& [synonym, key] : table.synonyms)
      if (letters_of(synonym) == letters) paths.push_back(inside + key);
  }
  return paths;
}

std::vector<std::string> names_in(const std::vector<Place>& places, const std::string& path) {
  std::vector<std::string> names;
  for (const Place& place : places)
    if (parent(place.path) == path) names.push_back(last_name(place.path));
  return names;
}

/// The full path of what an unknown `name` in the table at `path` probably means: a key there of which it is
/// a synonym or similarly spelled, or a key or table elsewhere.
std::optional<std::string> meaning_of(const std::string& name, const std::string& path,
                                      const std::vector<KnownTable>& tables) {
  const std::vector<std::string> called = keys_called(name, tables);
  const auto here = std::ranges::find(called, path, parent);
  if (here != called.end()) return *here;
  const std::vector<Place> places = places_in(tables);
  if (const auto nearest = nearest_name(name, names_in(places, path)))
    return path.empty() ? *nearest : path + "." + *nearest;
  for (const Place& place : places)
    if (last_name(place.path) == name) return place.path;
  return called.empty() ? std::nullopt : std::optional(called.front());
}

std::string advice(const std::string& name, const std::string& path, const std::vector<KnownTable>& tables) {
  if (const auto meant = meaning_of(name, path, tables))
    return fmt::format("did you mean {}?", parent(*meant) == path ? last_name(*meant) : *meant);
  return fmt::format("known here: {}", fmt::join(names_in(places_in(tables), path), ", "));
}

void visit(const Value& table, const std::string& path, const std::string& key,
           const std::vector<Place>& places, const std::vector<KnownTable>& tables, Findings& findings) {
  for (const Member& member : table.members) {
    const Value& value = member.value;
    const std::string member_path = path.empty() ? member.name : path + "." + member.name;
    const std::string member_key = key.empty() ? member.name : key + "." + member.name;
    const auto place = std::ranges::find(places, member_path, &Place::path);
    const bool is_table = value.kind == ValueKind::table;
    const auto report = [&](const std::string& message) { findings.report(member_key, value.line, message); };
    if (place == places.end() || member.name.find('.') != std::string::npos) {
      const bool has_tables = is_table || (value.kind == ValueKind::array && !value.elements.empty() &&
                                           value.elements.front().kind == ValueKind::table);
      findings.report(
          shortened(member_key, 100), value.line,
          fmt::format("unknown {}; {}", has_tables ? "table" : "key", advice(member.name, path, tables)));
    } else if (place->form == Place::Form::table ||
               (place->form == Place::Form::either && value.kind != ValueKind::array)) {
      if (is_table) {
        visit(value, member_path, member_key, places, tables, findings);
      } else if (value.kind == ValueKind::array) {
        report(fmt::format("this table can be given only once; write [{}], in single brackets", member_path));
      } else {
        report(fmt::format("{} is {}; give a table [{}]", value.source, describe(value.kind), member_path));
      }
    } else if (place->form != Place::Form::key) {
      bool sound = value.kind == ValueKind::array;
      if (sound) visit(value, member_path, member_key, places, tables, findings);
      for (std::size_t i = 0; sound && i < value.elements.size(); ++i) {
        sound = value.elements[i].kind == ValueKind::table;
        if (sound)
          visit(value.elements[i], member_path, fmt::format("{}[{}]", member_key, i), places, tables,
                findings);
      }
      if (!sound)
        report(fmt::format("this is a list of tables; write [[{}]], in double brackets", member_path));
    }
  }
}

/// Without array indices: "boundary.rate" of "boundary[1].rate[2]".
std::string without_numbers(const std::string& path) {
  std::string result;
  int depth = 0;
  for (const char c : path) {
    depth += c == '[' ? 1 : 0;
    if (depth == 0) result += c;
    depth -= c == ']' ? 1 : 0;
  }
  return result;
}

}  // namespace

const Key* find_key(const std::string& path) {
  const std::string wanted = without_numbers(path);
  for (const Table& table : schema())
    for (const Key& key : table.keys)
      if (table.path + "." + key.name == wanted) return &key;
  return nullptr;
}

std::string advice_on_key(const std::string& path, const std::string& accepted) {
  const std::string table = without_numbers(parent(path));
  const auto meant = meaning_of(last_name(without_numbers(path)), table, known_tables());
  if (!meant) return "give " + accepted;
  const bool is_here = !table.empty() && parent(*meant) == table;
  return fmt::format("did you mean \"{}\"?", is_here ? parent(path) + "." + last_name(*meant) : *meant);
}

std::vector<KnownTable> known_tables() {
  std::vector<KnownTable> known;
  for (const Table& table : schema()) known.push_back(names_in(table));
  return known;
}

void report_unknown_keys(const Value& root, const std::vector<KnownTable>& tables, Findings& findings) {
  visit(root, "", "", places_in(tables), tables, findings);
}

}  // namespace crackle::input
