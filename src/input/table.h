// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "document.h"
#include "findings.h"
#include "values.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// Tables of keys, from which files in TOML are read and their keys explained: the input, and experiments.
namespace crackle::input {

/// Treatment of a missing key.
struct Requirement {
  bool required = true;
  std::string fallback;              ///< default as written in the file; empty: the value stays unset
  std::string unset;                 ///< meaning of an unset value, for the table of keys
  std::vector<std::string> instead;  ///< keys of the same table, one of which can replace a required one
};
inline Requirement required() {
  return {};
}
inline Requirement required_unless(std::vector<std::string> keys) {
  return {true, {}, {}, std::move(keys)};
}
inline Requirement by_default(std::string value) {
  return {false, std::move(value), {}, {}};
}
inline Requirement optional(std::string meaning) {
  return {false, {}, std::move(meaning), {}};
}

/// A key of a table that describes a `Target`, such as the parameters.
template <class Target>
struct BasicKey {
  std::string name;       ///< within its table; "region.y" for a member of a nested table
  std::string dimension;  ///< for the table of keys
  Requirement requirement;
  std::string accepted;
  std::string help;
  /// The number is that of the table in an array of tables.
  std::function<void(const Source&, Target&, std::size_t)> read;
  /// Text for the echo; empty if the key does not apply.
  std::function<std::optional<std::string>(Target&, std::size_t)> show;
  /// What textbooks and other programs call it: "nu". They are not accepted; the error names the key.
  std::vector<std::string> synonyms = {};
  Affects affects = Affects::sample;

  BasicKey also_called(std::vector<std::string> names) && {
    synonyms = std::move(names);
    return std::move(*this);
  }
  BasicKey that_affects(Affects what) && {
    affects = what;
    return std::move(*this);
  }
};

enum class Occurrence { once, optional, many, once_or_many };

template <class Target>
struct BasicTable {
  std::string path;  ///< empty for the keys before the first table
  Occurrence occurrence = Occurrence::once;
  std::string help;
  std::vector<BasicKey<Target>> keys;
  /// Number of these tables in the target; empty: one, always.
  std::function<std::size_t(const Target&)> count = {};
  std::function<void(Target&)> append = {};  ///< adds one to the target; empty: it has it
  /// The table of which this is a part, if that may occur several times; the number of this one is then that
  /// of its whole.
  std::string part_of = {};
};

/// "material[1].variation" for "material.variation", a part of "material", if there are several.
std::string numbered(const std::string& path, const std::string& of, std::size_t i);

/// "[path]", or "[[path]]" of an array of tables.
template <class Target>
std::string header_of(const BasicTable<Target>& table) {
  return table.occurrence == Occurrence::many ? "[[" + table.path + "]]" : "[" + table.path + "]";
}

/// The names in a table.
struct KnownTable {
  std::string path;
  Occurrence occurrence;
  std::vector<std::string> keys;
  std::vector<std::pair<std::string, std::string>> synonyms;  ///< each with its key
};

template <class Target>
KnownTable names_in(const BasicTable<Target>& table) {
  KnownTable known{table.path, table.occurrence, {}, {}};
  for (const auto& key : table.keys) {
    known.keys.push_back(key.name);
    for (const std::string& synonym : key.synonyms) known.synonyms.emplace_back(synonym, key.name);
  }
  return known;
}

/// Reports every key and table of the document missing in `tables`, with the nearest known name, and tables
/// of the wrong form ([name] instead of [[name]], a number instead of a table).
void report_unknown_keys(const Value& root, const std::vector<KnownTable>& tables, Findings& findings);

/// Records the lines of a value and of everything in it.
/// @param key of the value; empty for the whole document
void locate(const Value& value, const std::string& key, Findings& findings);

/// The text of a file in TOML, or its first max_text_size + 1 bytes.
/// @param wanted in messages: "an input file in TOML"
/// @throws InputError when it cannot be read
std::string read_text_file(const std::filesystem::path& file, const std::string& wanted);

/// A missing key as a comment: "#seed = 0" after "# meaning: accepted values".
std::string commented_out(const std::string& name, const Requirement& requirement,
                          const std::string& accepted, const std::string& help);

/// Reads the keys of one table of the document. Missing keys get their defaults, or are reported.
/// @param name of the table in messages
template <class Target>
void read_table(const BasicTable<Target>& table, const Value& value, const std::string& name, Target& target,
                std::size_t index, Context& context) {
  for (const auto& key : table.keys) {
    const std::string key_name = name.empty() ? key.name : name + "." + key.name;
    const Requirement& requirement = key.requirement;
    if (const Value* given = find_path(value, key.name)) {
      key.read({*given, key_name, context}, target, index);
    } else if (requirement.required) {
      if (std::ranges::any_of(requirement.instead,
                              [&](const auto& other) { return find_path(value, other) != nullptr; }))
        continue;
      context.findings.report(key_name, "the key is missing; give {}", key.accepted);
    } else if (!requirement.fallback.empty()) {
      const Value document = parse_document("value = " + requirement.fallback);
      key.read({*document.find("value"), key_name, context}, target, index);
    }
  }
}

}  // namespace crackle::input
