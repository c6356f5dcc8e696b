// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/reader.h"

#include <string>
#include <utility>
#include <vector>

/// Input texts for tests, built key by key.
namespace crackle::test {

/// One table of an input: its header as written, and its keys with their values as written.
struct InputTable {
  std::string header;
  std::vector<std::pair<std::string, std::string>> keys;
};

/// An input with the required keys only.
inline std::vector<InputTable> minimal_tables() {
  return {{"[ensemble]", {{"samples", "3"}}},
          {"[specimen]", {{"size", R"(["5 mm", "24.5 mm", "140 mm"])"}}},
          {"[mesh]", {{"spacing", R"("2 mm")"}}},
          {"[material]",
           {{"youngs_modulus", R"("3300 MPa")"}, {"poisson_ratio", "0.38"}, {"density", R"("1180 kg/m^3")"}}},
          {"[fracture]", {{"strength", R"("35 MPa")"}, {"impulse", R"("1e-8 MPa^2 s")"}}},
          {"[[boundary]]", {{"on", R"("z-min")"}, {"fix", R"(["x", "y", "z"])"}}},
          {"[time]", {{"duration", R"("100 us")"}}},
          {"[sections]", {{"y", R"(["12.25 mm"])"}}}};
}

/// Sets a key of the table; adds whatever is missing.
inline void set_key(std::vector<InputTable>& tables, const std::string& header, const std::string& key,
                    const std::string& value) {
  for (InputTable& table : tables) {
    if (table.header != header) continue;
    for (auto& [name, old] : table.keys) {
      if (name == key) {
        old = value;
        return;
      }
    }
    table.keys.emplace_back(key, value);
    return;
  }
  tables.push_back({header, {{key, value}}});
}

inline std::string to_text(const std::vector<InputTable>& tables) {
  std::string text;
  for (const InputTable& table : tables) {
    text += table.header + "\n";
    for (const auto& [key, value] : table.keys) text += key + " = " + value + "\n";
  }
  return text;
}

inline input::Parameters parse_tables(const std::vector<InputTable>& tables) {
  return input::parse(to_text(tables), "test.toml");
}

/// The minimal input with one key changed or added.
inline input::Parameters parse_with(const std::string& header, const std::string& key,
                                    const std::string& value) {
  auto tables = minimal_tables();
  set_key(tables, header, key, value);
  return parse_tables(tables);
}

/// The error messages of an input; empty for a correct one.
inline std::vector<std::string> errors_of(const std::string& text) {
  try {
    input::parse(text, "test.toml");
  } catch (const input::InputError& error) {
    return error.messages();
  }
  return {};
}

inline std::vector<std::string> errors_with(const std::string& header, const std::string& key,
                                            const std::string& value) {
  auto tables = minimal_tables();
  set_key(tables, header, key, value);
  return errors_of(to_text(tables));
}

}  // namespace crackle::test
