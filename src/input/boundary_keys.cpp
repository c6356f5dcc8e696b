// SPDX-License-Identifier: GPL-3.0-or-later
#include "consistency.h"
#include "kinds.h"

#include <algorithm>
#include <array>

namespace crackle::input {

namespace {

Boundary& boundary(Parameters& parameters, std::size_t i) {
  return parameters.boundaries.at(i);
}

/// True if components may be left free: motions are prescribed by component, loads as vectors.
bool may_be_free(BoundaryKind kind) {
  return prescribes_motion(kind) && has_quantity(kind);
}

Range value_range(BoundaryKind kind) {
  const bool motion = may_be_free(kind);
  return {motion ? -1e6 : -1e15, motion ? 1e6 : 1e15};
}

constexpr Range rate_range{-1e18, 1e18};

const std::string accepted_face =
    "\"x-min\", \"x-max\", \"y-min\", \"y-max\", \"z-min\", \"z-max\", or a name such as \"edge-0\", "
    "\"hole-0\" or \"notch-0\"";

/// A load has all three components.
std::array<bool, 3> given_components(const Boundary& condition) {
  return may_be_free(condition.kind) ? condition.components : std::array<bool, 3>{true, true, true};
}

Key on_key() {
  return {"on",
          "word",
          required(),
          accepted_face,
          "edge-i runs from point i of the outline to the next (in a box z-min, y-max, z-max, y-min); hole-i "
          "and notch-i are all walls of these; z-min and the like are all edges at that end",
          [](const Source& source, Parameters& parameters, std::size_t i) {
            if (const auto name = read_text(source, accepted_face)) boundary(parameters, i).on = *name;
          },
          [](Parameters& parameters, std::size_t i) { return boundary(parameters, i).on; }};
}

Key region_key(std::size_t axis) {
  return range_key(
             fmt::format("region.{}", axis_names[axis]),
             [=](Parameters & parameters, std::size_t i) -> auto& {
               return boundary(parameters, i).region[axis];
             },
             {"50 mm", "100 mm"}, "whole face", "part of the face; with equal limits a line of nodes", true)
      .that_affects(Affects::points);
}

Key fix_key() {
  return {"fix",
          "words",
          one_of_kinds(kind_names),
          distinct_axes,
          "zero displacement of these components",
          [](const Source& source, Parameters& parameters, std::size_t i) {
            boundary(parameters, i).kind = BoundaryKind::fix;
            boundary(parameters, i).components = read_axes(source);
          },
          [](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            const Boundary& condition = boundary(parameters, i);
            if (condition.kind != BoundaryKind::fix) return {};
            return show_axes(condition.components);
          }};
}

Key prescription_key(BoundaryKind kind, const std::string& help) {
  const Dimension& dimension = value_dimension(kind);
  const bool free = may_be_free(kind);
  return {name_of(kind),
          name_without_article(dimension),
          one_of_kinds(kind_names),
          components_form(dimension, free),
          help,
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            const auto components = read_components(source, dimension, value_range(kind), free);
            Boundary& condition = boundary(parameters, i);
            condition.kind = kind;
            if (!components) return;
            condition.value = components->value;
            const auto& prescribed = components->prescribed;
            if (free) condition.components = prescribed;
            if (std::none_of(prescribed.begin(), prescribed.end(), [](bool p) { return p; })) {
              source.report("all three components are free; prescribe at least one, such as \"{}\"",
                            dimension.example);
            }
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            const Boundary& condition = boundary(parameters, i);
            if (condition.kind != kind) return {};
            return show_components(condition.value, dimension, given_components(condition));
          }};
}

Key pressure_key() {
  const Dimension& dimension = value_dimension(BoundaryKind::pressure);
  return {name_of(BoundaryKind::pressure),
          "stress",
          one_of_kinds(kind_names),
          quantity_form(dimension),
          "above 0 it presses on the body",
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            Boundary& condition = boundary(parameters, i);
            condition.kind = BoundaryKind::pressure;
            if (const auto value = read_quantity(source, dimension, value_range(BoundaryKind::pressure)))
              condition.value[0] = *value;
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            const Boundary& condition = boundary(parameters, i);
            if (condition.kind != BoundaryKind::pressure) return {};
            return format_quantity(condition.value[0], dimension);
          }};
}

Key absorbing_key() {
  return {name_of(BoundaryKind::absorbing),
          "boolean",
          one_of_kinds(kind_names),
          "true",
          "lets waves leave the body; requires time.integrator = \"verlet\"",
          [](const Source& source, Parameters& parameters, std::size_t i) {
            boundary(parameters, i).kind = BoundaryKind::absorbing;
            if (source.value.kind != ValueKind::boolean || !source.value.boolean)
              source.report("{} is not accepted; give true, or leave this boundary out", source.value.source);
          },
          [](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            if (boundary(parameters, i).kind != BoundaryKind::absorbing) return {};
            return "true";
          }};
}

Key rate_key() {
  return {"rate",
          "as prescribed, per time",
          optional("constant in time"),
          "three components, such as [\"0 N/s\", \"0 N/s\", \"5 N/s\"]; for a pressure a single value",
          "increase with time",
          [](const Source& source, Parameters& parameters, std::size_t i) {
            Boundary& condition = boundary(parameters, i);
            const std::string table = source.key.substr(0, source.key.rfind('.'));
            // With none or several kinds the dimension is unknown; that is reported separately.
            if (kinds_given(source.context.findings, table, kind_names).size() != 1) return;
            if (condition.kind == BoundaryKind::fix) {
              source.report("a fixed boundary does not change with time; give a displacement instead of fix");
              return;
            }
            if (condition.kind == BoundaryKind::absorbing) {
              source.report("an absorbing boundary does not change with time; leave it out");
              return;
            }
            if (condition.kind == BoundaryKind::pressure) {
              if (const auto rate = read_quantity(source, rate_dimension(condition.kind), rate_range))
                condition.rate[0] = *rate;
              return;
            }
            const bool free = may_be_free(condition.kind);
            const auto rate = read_components(source, rate_dimension(condition.kind), rate_range, free);
            if (!rate || source.context.findings.faulty(table + "." + name_of(condition.kind))) return;
            for (std::size_t axis = 0; axis < 3; ++axis) {
              if (rate->value[axis] != 0 && !given_components(condition)[axis]) {
                source.report("component {} is free and cannot have a rate; give \"free\" here too",
                              axis_names[axis]);
              }
            }
            condition.rate = rate->value;
          },
          [](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            const Boundary& condition = boundary(parameters, i);
            if (condition.rate == Vector{}) return {};
            if (condition.kind == BoundaryKind::pressure)
              return format_quantity(condition.rate[0], rate_dimension(condition.kind));
            return show_components(condition.rate, rate_dimension(condition.kind),
                                   given_components(condition));
          }};
}

}  // namespace

Table boundary_table() {
  Table table{
      "boundary",
      Occurrence::many,
      fmt::format("boundary conditions; each prescribes exactly one of {}", fmt::join(kind_names, ", ")),
      {on_key().that_affects(Affects::place), region_key(0), region_key(1), region_key(2), fix_key(),
       prescription_key(BoundaryKind::force, "total force, spread by area").also_called({"F", "load"}),
       prescription_key(BoundaryKind::traction, "force per area").also_called({"t"}),
       prescription_key(BoundaryKind::velocity, "\"free\" where it is not prescribed")
           .also_called({"v", "speed"}),
       prescription_key(BoundaryKind::displacement, "\"free\" where it is not prescribed")
           .also_called({"u", "d"}),
       pressure_key().also_called({"p"}), absorbing_key(), rate_key(),
       history_key(
           [](Parameters & parameters, std::size_t i) -> auto& { return boundary(parameters, i).history; },
           "factors, linear between these times")},
      [](const Parameters& parameters) { return parameters.boundaries.size(); },
      [](Parameters& parameters) { parameters.boundaries.emplace_back(); }};
  for (Key& key : profile_keys(
           "factor",
           [](Parameters & parameters, std::size_t i) -> auto& { return boundary(parameters, i).factor; },
           "factors along this coordinate, linear between, constant outside; a force keeps its total"))
    table.keys.push_back(std::move(key));
  table.keys.push_back(name_key(
      [](Parameters & parameters, std::size_t i) -> auto& { return boundary(parameters, i).name; },
      optional("none"), "rollers", "conditions of one name are one load of the testing machine"));
  return table;
}

}  // namespace crackle::input
