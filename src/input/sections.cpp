// SPDX-License-Identifier: GPL-3.0-or-later
#include "consistency.h"
#include "dimension.h"
#include "document.h"
#include "findings.h"
#include "input/reader.h"
#include "schema.h"
#include "units.h"
#include "values.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>

namespace crackle::input {

namespace {

/// Line number of values that do not come from a file.
constexpr int no_line = 0;

Value string_value(std::string_view text) {
  Value value;
  value.kind = ValueKind::string;
  value.line = no_line;
  value.string = text;
  value.source = fmt::format("\"{}\"", shortened(value.string));
  return value;
}

Value empty_array() {
  Value array;
  array.kind = ValueKind::array;
  array.line = no_line;
  return array;
}

/// Appends the texts between the commas to an array.
void add_elements(std::string_view list, Value& array) {
  for (std::size_t start = 0; start <= list.size();) {
    const std::size_t end = std::min(list.find(',', start), list.size());
    array.elements.push_back(string_value(trimmed(list.substr(start, end - start))));
    start = end + 1;
  }
}

}  // namespace

std::vector<Section> Sections::all() const {
  std::vector<Section> sections;
  for (const double position : y) sections.push_back({1, position});
  for (const double position : z) sections.push_back({2, position});
  for (const SectionLine& line : lines) sections.push_back({0, 0, line});
  return sections;
}

std::string name_of(const Section& section) {
  if (section.axis == 0) {
    const auto& [from, to] = section.line;
    return fmt::format("line from ({}, {}) to ({}, {})", show(from[0]), show(from[1]), show(to[0]),
                       show(to[1]));
  }
  return fmt::format("{} = {}", section.axis == 1 ? "y" : "z",
                     format_quantity(section.position, length_dimension));
}

const char* coordinate_of(const Section& section) {
  return section.axis == 1 ? "z" : section.axis == 2 ? "y" : "distance";
}

std::vector<std::string> as_given(const Sections& sections) {
  const auto list = [](const auto& lengths) {
    std::vector<std::string> items;
    for (const double length : lengths) items.push_back(show(length));
    return fmt::format("{}", fmt::join(items, ", "));
  };
  std::vector<std::string> given;
  if (!sections.y.empty()) given.push_back(fmt::format("y=\"{}\"", list(sections.y)));
  if (!sections.z.empty()) given.push_back(fmt::format("z=\"{}\"", list(sections.z)));
  for (const auto& [from, to] : sections.lines)
    given.push_back(fmt::format("line=\"{}; {}\"", list(from), list(to)));
  return given;
}

Parameters with_sections(Parameters parameters, const std::vector<std::string>& given,
                         const std::string& name) {
  const GivenFiles no_files;
  Findings findings;
  Context context{UnitSystem::shared(), findings, {}, no_files};
  findings.locate("sections", no_line);
  parameters.sections = {};
  std::map<std::string, Value> arrays;
  std::vector<std::map<std::string, Value>> lines;
  for (const std::string& list : given) {
    const auto equals = list.find('=');
    const std::string kind(trimmed(std::string_view(list).substr(0, equals)));
    const std::string_view values =
        equals == std::string::npos ? "" : std::string_view(list).substr(equals + 1);
    if (kind == "line" && std::ranges::count(values, ';') == 1) {
      const auto semicolon = values.find(';');
      auto& line = lines.emplace_back();
      add_elements(values.substr(0, semicolon), line.emplace("from", empty_array()).first->second);
      add_elements(values.substr(semicolon + 1), line.emplace("to", empty_array()).first->second);
    } else if (equals != std::string::npos && (kind == "y" || kind == "z")) {
      add_elements(values, arrays.emplace(kind, empty_array()).first->second);
    } else {
      findings.report("", no_line,
                      fmt::format("\"{}\" is not known; give y=\"7 mm, 12.25 mm\", z=\"30 mm\" or line=\"1 "
                                  "mm, 2 mm; 3 mm, 4 mm\" (y and z of the ends)",
                                  shortened(list)));
    }
  }
  const auto read = [&](const Table& table, const std::map<std::string, Value>& values,
                        const std::string& name, std::size_t i) {
    for (const Key& key : table.keys) {
      const auto value = values.find(key.name);
      if (value != values.end()) key.read({value->second, name + "." + key.name, context}, parameters, i);
    }
  };
  for (const Table& table : schema()) {
    if (table.path == "sections") read(table, arrays, table.path, 0);
    if (table.path != "sections.line") continue;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      table.append(parameters);
      read(table, lines[i], fmt::format("{}[{}]", table.path, i), i);
    }
  }
  if (parameters.sections.size() > 0) check_sections(parameters, findings);
  if (!findings.empty()) throw InputError(findings.messages(name));
  return parameters;
}

}  // namespace crackle::input
