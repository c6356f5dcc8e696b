// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/input/reader.h"
#include "schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace crackle::input {

std::string echo(const Parameters& parameters) {
  Parameters shown = parameters;
  std::vector<std::pair<std::string, std::string>> lines;
  std::size_t width = 0;
  for (const Table& table : schema()) {
    for (std::size_t i = 0; i < table.count(shown); ++i) {
      const std::string path =
          table.occurrence == Occurrence::many ? fmt::format("{}[{}]", table.path, i) : table.path;
      for (const Key& key : table.keys) {
        const auto text = key.show(shown, i);
        if (!text) continue;
        lines.emplace_back(path + "." + key.name, *text);
        width = std::max(width, lines.back().first.size());
      }
    }
  }
  std::string result;
  for (const auto& [key, text] : lines) result += fmt::format("{:<{}} = {}\n", key, width, text);
  return result;
}

std::string key_table() {
  std::string result =
      "| key | dimension | default | accepted | meaning |\n"
      "|---|---|---|---|---|\n";
  for (const Table& table : schema()) {
    const bool many = table.occurrence == Occurrence::many;
    const std::string header = many ? "[[" + table.path + "]]" : "[" + table.path + "]";
    const char* occurrence = many ? "any number" : table.occurrence == Occurrence::optional ? "optional" : "";
    result += fmt::format("| **`{}`** | | {} | | {} |\n", header, occurrence, table.help);
    for (const Key& key : table.keys) {
      const Presence& presence = key.presence;
      const std::string fallback = presence.required           ? "required"
                                   : presence.fallback.empty() ? presence.unset
                                                               : "`" + presence.fallback + "`";
      result += fmt::format("| `{}` | {} | {} | {} | {} |\n", key.name, key.dimension, fallback, key.accepted,
                            key.help);
    }
  }
  return result;
}

}  // namespace crackle::input
