// SPDX-License-Identifier: GPL-3.0-or-later
#include "consistency.h"
#include "schema.h"

#include "common/index.h"

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace crackle::input {

namespace {

/// The number of a boundary condition is an int; its existence is checked later.
constexpr int max_conditions = 1'000'000;
/// Maximum number of history rows in one dynamic phase.
constexpr double max_history_rows = 100'000;

Probe& probe(Parameters& parameters, std::size_t i) {
  return parameters.output.probes.at(i);
}

Key governing_key() {
  const std::string form =
      "the name of a [[boundary]] or [[tool]], such as \"rollers\", or the number of a [[boundary]], counted "
      "from 0";
  return {"governing",
          "text or integer",
          optional("the driving condition"),
          form,
          "condition, with all others of its name, whose load and displacement the results give; the driving "
          "one is the first that changes with time, else the first with a value other than 0",
          [=](const Source& source, Parameters& parameters, std::size_t) {
            if (source.value.kind == ValueKind::integer) {
              if (const auto number = read_integer(source, 0, max_conditions))
                parameters.governing = static_cast<int>(*number);
            } else if (const auto name = read_text(source, form)) {
              parameters.governing = *name;
            }
          },
          [](Parameters& parameters, std::size_t) -> std::optional<std::string> {
            const auto& governing = parameters.governing;
            if (const auto* const number = std::get_if<int>(&governing)) return fmt::format("{}", *number);
            if (const auto* const name = std::get_if<std::string>(&governing)) return *name;
            return {};
          }};
}

/// True if a point in the plane of the plate lies in the material, or within `slack` of it.
bool in_shape(const plane::Shape& shape, const plane::Point& p, double slack) {
  bool is_inside = true;
  double nearest = infinity;
  for (std::size_t k = 0; k < shape.loops.size(); ++k) {
    const plane::Loop& loop = shape.loops[k];
    is_inside = is_inside && plane::holds(loop.corners, p) == (k == 0);
    for (std::size_t i = 0; i < loop.size(); ++i)
      nearest = std::min(nearest, plane::distance(p, loop.from(i), loop.to(i)));
  }
  return is_inside || nearest <= slack;
}

/// Why a point is not in the body; empty if it is.
std::optional<std::string> reason_outside(const plane::Specimen& specimen, const Vector& p) {
  const plane::Region bounds = bounds_of(specimen);
  double extent = 0;
  for (const auto& [lower, upper] : bounds) extent = std::max(extent, upper - lower);
  const double slack = 1e-9 * extent;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [lower, upper] = bounds[axis];
    if (p[axis] < lower - slack || p[axis] > upper + slack)
      return fmt::format("{} = {} is outside the body; give a length from {} to {}", axis_names[axis],
                         shown_length(p[axis]), shown_length(lower), shown_length(upper));
  }
  if (specimen.solid) {
    if (solid::contains(*specimen.solid, p, slack)) return {};
    return "the position is outside the body; give one in it";
  }
  if (specimen.shape) {
    if (in_shape(*specimen.shape, {p[1], p[2]}, slack)) return {};
    return "the position is outside the body, or in a hole or a notch; give one in the material";
  }
  for (std::size_t i = 0; i < specimen.notches.size(); ++i) {
    const plane::Region slot = slot_of(specimen.notches[i], bounds_of(specimen));
    bool is_inside = true;
    for (std::size_t axis = 1; axis < 3; ++axis)
      is_inside = is_inside && p[axis] > slot[axis].first + slack && p[axis] < slot[axis].second - slack;
    if (is_inside) return fmt::format("the position is in specimen.notch[{}]; give one in the material", i);
  }
  return {};
}

/// Of the boundaries and tools; empty for those without a name.
std::vector<std::string> condition_names(const Model& model) {
  std::vector<std::string> names;
  for (const Boundary& condition : model.boundaries) names.push_back(condition.name);
  for (std::size_t i = 0; i < model.tools.size(); ++i) names.push_back(name_of(model.tools[i], i));
  return names;
}

/// Advice which condition to give: "give one of 0 to 3, \"rollers\"".
std::string known_conditions(const Parameters& parameters) {
  const std::size_t n = parameters.boundaries.size();
  std::vector<std::string> known;
  if (n > 0) known.push_back(n == 1 ? "0" : fmt::format("0 to {}", n - 1));
  for (const std::string& one : condition_names(parameters)) {
    const std::string name = fmt::format("\"{}\"", one);
    if (!one.empty() && std::ranges::find(known, name) == known.end()) known.push_back(name);
  }
  return known.empty() ? "leave it out" : fmt::format("give one of {}", fmt::join(known, ", "));
}

void check_governing(const Parameters& parameters, Findings& findings) {
  const auto& governing = parameters.governing;
  const std::vector<std::string> names = condition_names(parameters);
  if (findings.faulty("output.governing") || findings.faulty("boundary")) return;
  if (const auto* const number = std::get_if<int>(&governing);
      number != nullptr && *number >= std::ssize(parameters.boundaries))
    findings.report("output.governing", "there is no boundary[{}]; {}", *number,
                    known_conditions(parameters));
  if (const auto* const name = std::get_if<std::string>(&governing);
      name != nullptr && std::ranges::find(names, *name) == names.end())
    findings.report("output.governing", "no [[boundary]] or [[tool]] is called \"{}\"; {}", shortened(*name),
                    known_conditions(parameters));
}

}  // namespace

Table output_table() {
  Key history = automatic_time_key(
      "history", [](Parameters & parameters, std::size_t) -> auto& { return parameters.output.history; },
      "0.5 us", "between rows in dynamic phases; \"auto\" is 1/200 of the duration");
  // Treated as if not given.
  history = shown_if(std::move(history), [](const Parameters& parameters, std::size_t) {
    return parameters.output.history.has_value();
  });
  return {
      "output",
      Occurrence::once,
      "what the sample files hold",
      {integer_key<int>(
           "frames", [](Parameters & parameters, std::size_t) -> auto& { return parameters.output.frames; },
           0, 100'000, by_default("11"), "snapshots of the fields during the dynamic phase"),
       std::move(history), governing_key(),
       optional_quantity_key(
           "branch_length",
           [](Parameters & parameters, std::size_t) -> auto& { return parameters.output.branch_length; },
           with_example(length_dimension, "2 mm"), positive_length,
           optional("4 spacings, the largest where cracks run"),
           "from which branches count as long; give it to compare meshes, since a finer one shows shorter "
           "branches")}};
}

Table probe_table() {
  return {"output.probe",
          Occurrence::many,
          "a position at which the history records displacement, velocity and stress",
          {name_key(
               [](Parameters & parameters, std::size_t i) -> auto& { return probe(parameters, i).name; },
               required(), "gauge", "unique among the probes"),
           lengths_key<Vector>(
               "at", [](Parameters & parameters, std::size_t i) -> auto& { return probe(parameters, i).at; },
               "three lengths, x, y and z, such as [\"2.5 mm\", \"12 mm\", \"40 mm\"]", coordinate,
               required(), "position in the body")},
          [](const Parameters& parameters) { return parameters.output.probes.size(); },
          [](Parameters& parameters) { parameters.output.probes.emplace_back(); }};
}

void check_output(const Parameters& parameters, Findings& findings) {
  const auto& history = parameters.output.history;
  const auto& probes = parameters.output.probes;
  check_governing(parameters, findings);
  if (history && !findings.faulty("output.history") && !findings.faulty("time.duration") &&
      parameters.time.duration / *history > max_history_rows)
    findings.report("output.history", "{} gives more than {:.0f} rows in {}; give a longer time",
                    format_quantity(*history, time_dimension), max_history_rows,
                    format_quantity(parameters.time.duration, time_dimension));
  std::set<std::string> names;
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const std::string key = fmt::format("output.probe[{}]", i);
    if (!findings.faulty(key + ".name") && !names.insert(probes[i].name).second)
      findings.report(key + ".name", "another probe is called \"{}\"; give another name", probes[i].name);
    if (findings.faulty(key + ".at") || !size_is_known(findings) || findings.faulty("specimen")) continue;
    if (const auto reason = reason_outside(parameters.specimen, probes[i].at))
      findings.report(key + ".at", "{}", *reason);
  }
}

}  // namespace crackle::input
