// SPDX-License-Identifier: GPL-3.0-or-later
#include "schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
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

/// Levenshtein distance.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

/// Suggests a replacement for an unknown `name` in the table at `path`: a similarly spelled name there, the
/// same name in another table, or otherwise all names of the table.
std::string advice(const std::vector<Place>& places, const std::string& path, const std::string& name) {
  std::vector<std::string> siblings;
  const Place* nearest = nullptr;
  std::size_t smallest = std::max<std::size_t>(2, name.size() / 3) + 1;
  for (const Place& place : places) {
    if (parent(place.path) != path) continue;
    siblings.push_back(last_name(place.path));
    const std::size_t distance = edit_distance(name, siblings.back());
    if (distance < smallest && distance < name.size()) {
      smallest = distance;
      nearest = &place;
    }
  }
  if (nearest != nullptr) return fmt::format("did you mean {}?", last_name(nearest->path));
  for (const Place& place : places)
    if (last_name(place.path) == name) return fmt::format("did you mean {}?", place.path);
  return fmt::format("known here: {}", fmt::join(siblings, ", "));
}

void visit(const Value& table, const std::string& path, const std::string& key,
           const std::vector<Place>& places, Findings& findings) {
  for (const Member& member : table.members) {
    const Value& value = member.value;
    const std::string member_path = path.empty() ? member.name : path + "." + member.name;
    const std::string member_key = key.empty() ? member.name : key + "." + member.name;
    const auto place = std::ranges::find(places, member_path, &Place::path);
    const bool is_table = value.kind == ValueKind::table;
    const auto report = [&](const std::string& message) { findings.report(member_key, value.line, message); };
    if (place == places.end() || member.name.find('.') != std::string::npos) {
      const bool tables = is_table || (value.kind == ValueKind::array && !value.elements.empty() &&
                                       value.elements.front().kind == ValueKind::table);
      findings.report(
          shortened(member_key, 100), value.line,
          fmt::format("unknown {}; {}", tables ? "table" : "key", advice(places, path, member.name)));
    } else if (place->form == Place::Form::table ||
               (place->form == Place::Form::either && value.kind != ValueKind::array)) {
      if (is_table) {
        visit(value, member_path, member_key, places, findings);
      } else if (value.kind == ValueKind::array) {
        report(fmt::format("this table can be given only once; write [{}], in single brackets", member_path));
      } else {
        report(fmt::format("{} is {}; give a table [{}]", value.source, describe(value.kind), member_path));
      }
    } else if (place->form != Place::Form::key) {
      bool sound = value.kind == ValueKind::array;
      for (std::size_t i = 0; sound && i < value.elements.size(); ++i) {
        sound = value.elements[i].kind == ValueKind::table;
        if (sound)
          visit(value.elements[i], member_path, fmt::format("{}[{}]", member_key, i), places, findings);
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

std::vector<KnownTable> known_tables() {
  std::vector<KnownTable> known;
  for (const Table& table : schema()) known.push_back(names_in(table));
  return known;
}

void report_unknown_keys(const Value& root, const std::vector<KnownTable>& tables, Findings& findings) {
  visit(root, "", "", places_in(tables), findings);
}

}  // namespace crackle::input
