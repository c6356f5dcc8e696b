// SPDX-License-Identifier: GPL-3.0-or-later
#include "consistency.h"
#include "crackle/input/reader.h"
#include "dimension.h"
#include "document.h"
#include "findings.h"
#include "schema.h"
#include "units.h"
#include "values.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>

namespace crackle::input {

namespace {

/// Values that come from no file.
constexpr int no_line = 0;

Value string_value(std::string_view text) {
  Value value;
  value.kind = ValueKind::string;
  value.line = no_line;
  value.string = text;
  value.source = fmt::format("\"{}\"", shortened(value.string));
  return value;
}

/// Adds the texts between the commas to an array.
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
  return sections;
}

std::string name_of(const Section& section) {
  return fmt::format("{} = {}", section.axis == 1 ? "y" : "z",
                     format_quantity(section.position, length_dimension));
}

Parameters with_sections(Parameters parameters, const std::vector<std::string>& given,
                         const std::string& name) {
  const PointsFile no_points;
  Findings findings;
  Context context{UnitSystem::shared(), findings, {}, no_points};
  findings.locate("sections", no_line);
  parameters.sections = {};
  std::map<std::string, Value> arrays;
  for (const std::string& list : given) {
    const auto equals = list.find('=');
    const std::string axis(trimmed(std::string_view(list).substr(0, equals)));
    if (equals == std::string::npos || (axis != "y" && axis != "z")) {
      findings.report(
          "", no_line,
          fmt::format("\"{}\" is not known; give y=\"7 mm, 12.25 mm\" or z=\"30 mm\"", shortened(list)));
      continue;
    }
    Value& array = arrays[axis];
    array.kind = ValueKind::array;
    array.line = no_line;
    add_elements(std::string_view(list).substr(equals + 1), array);
  }
  for (const Table& table : schema()) {
    if (table.path != "sections") continue;
    for (const Key& key : table.keys) {
      const auto array = arrays.find(key.name);
      if (array != arrays.end()) key.read({array->second, "sections." + key.name, context}, parameters, 0);
    }
  }
  if (parameters.sections.size() > 0) check_sections(parameters, findings);
  if (!findings.empty()) throw InputError(findings.messages(name));
  return parameters;
}

}  // namespace crackle::input
