// SPDX-License-Identifier: GPL-3.0-or-later
#include "kinds.h"

#include <algorithm>
#include <array>

namespace crackle::input {

Requirement one_of_kinds(std::span<const char* const> kinds) {
  return optional(fmt::format("one of {}", kinds.size()));
}

std::vector<std::string> kinds_given(const Findings& findings, const std::string& table,
                                     std::span<const char* const> kinds) {
  std::vector<std::string> given;
  for (const char* const kind : kinds)
    if (findings.given(fmt::format("{}.{}", table, kind))) given.emplace_back(kind);
  return given;
}

void check_kind(const std::string& table, const char* name, std::span<const char* const> kinds,
                Findings& findings) {
  const std::vector<std::string> given = kinds_given(findings, table, kinds);
  if (given.empty())
    findings.report(table, "prescribes nothing; give one of {}", fmt::join(kinds, ", "));
  else if (given.size() > 1)
    findings.report(table, "prescribes {}; give exactly one of {}, and the others in separate [[{}]] tables",
                    fmt::join(given, " and "), fmt::join(kinds, ", "), name);
}

std::string components_form(const Dimension& dimension, bool may_be_free) {
  const std::string zero = may_be_free ? "free" : "0 " + dimension.si_unit;
  return fmt::format("three components, such as [\"{0}\", \"{0}\", \"{1}\"]", zero, dimension.example);
}

std::optional<Components> read_components(const Source& source, const Dimension& dimension,
                                          const Range& range, bool may_be_free) {
  const auto elements = read_elements(source, 3, components_form(dimension, may_be_free));
  if (!elements) return {};
  Components result;
  bool sound = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Source& element = (*elements)[axis];
    if (element.value.kind == ValueKind::string && element.value.string == "free") {
      if (may_be_free) continue;
      element.report("a load has no free components; give {} such as \"0 {}\"", dimension.name,
                     dimension.si_unit);
      sound = false;
      continue;
    }
    const auto value = read_quantity(element, dimension, range);
    sound = sound && value.has_value();
    result.value[axis] = value.value_or(0);
    result.prescribed[axis] = true;
  }
  if (!sound) return {};
  return result;
}

std::optional<double> read_angular_velocity(const Source& source) {
  const auto value = read_quantity(source, angular_velocity_dimension, {-1e9, 1e9});
  const auto is_in_unit = [&](const char* angle) {
    return source.value.string.find(angle) != std::string::npos;
  };
  constexpr std::array angles{"rad", "deg", "\u00b0", "rpm", "rps", "rev", "turn", "cycle", "circle"};
  if (!value || std::ranges::any_of(angles, is_in_unit)) return value;
  source.report("{} has no unit of angle; give an angle per time, such as \"3000 rpm\" or \"314 rad/s\"",
                source.value.source);
  return {};
}

std::string show_components(const Vector& value, const Dimension& dimension,
                            const std::array<bool, 3>& prescribed) {
  std::vector<std::string> items;
  for (std::size_t axis = 0; axis < 3; ++axis)
    items.push_back(prescribed[axis] ? format_quantity(value[axis], dimension) : "free");
  return bracketed(items);
}

}  // namespace crackle::input
