// SPDX-License-Identifier: GPL-3.0-or-later
// [[load]]: forces on the whole body, and its velocity at the start.
#include "consistency.h"
#include "kinds.h"

#include <array>
#include <string_view>

namespace crackle::input {

namespace {

constexpr Range any_amount{-1e15, 1e15};
constexpr Range any_velocity{-1e6, 1e6};

BodyLoad& load(Parameters& parameters, std::size_t i) {
  return parameters.loads.at(i);
}

std::string load_key(std::size_t i) {
  return fmt::format("load[{}]", i);
}

Key vector_key(LoadKind kind, const Dimension& dimension, const Range& range, std::string help) {
  return {name_of(kind),
          name_without_article(dimension),
          one_of_kinds(load_kind_names),
          components_form(dimension),
          std::move(help),
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            load(parameters, i).kind = kind;
            if (const auto value = read_components(source, dimension, range))
              load(parameters, i).value = value->value;
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            if (load(parameters, i).kind != kind) return {};
            return show_components(load(parameters, i).value, dimension);
          }};
}

const Dimension& rate_dimension(LoadKind kind) {
  return kind == LoadKind::body_force ? body_force_rate_dimension : acceleration_rate_dimension;
}

bool has_rate(LoadKind kind) {
  return kind == LoadKind::acceleration || kind == LoadKind::body_force;
}

Key load_rate_key() {
  return {
      "rate",
      "as prescribed, per time",
      optional("constant in time"),
      components_form(acceleration_rate_dimension),
      "increase of an acceleration or body force with time",
      [](const Source& source, Parameters& parameters, std::size_t i) {
        const std::string table = load_key(i);
        // With none or several kinds the dimension is unknown; that is reported separately.
        if (kinds_given(source.context.findings, table, load_kind_names).size() != 1) return;
        const LoadKind kind = load(parameters, i).kind;
        if (!has_rate(kind)) {
          source.report(kind == LoadKind::angular_velocity
                            ? "the load of a rotation does not grow linearly with it; give a history, whose "
                              "factors multiply the load"
                            : "a velocity at the start does not change with time; leave it out");
          return;
        }
        if (const auto rate = read_components(source, rate_dimension(kind), {-1e18, 1e18}))
          load(parameters, i).rate = rate->value;
      },
      [](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
        const BodyLoad& one = load(parameters, i);
        if (one.rate == Vector{}) return {};
        return show_components(one.rate, rate_dimension(one.kind));
      }};
}

Key angular_velocity_key() {
  const Dimension& dimension = angular_velocity_dimension;
  return {name_of(LoadKind::angular_velocity),
          name_without_article(dimension),
          one_of_kinds(load_kind_names),
          quantity_form(dimension),
          "centrifugal force in a rotating frame; a history multiplies the force",
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            load(parameters, i).kind = LoadKind::angular_velocity;
            if (const auto value = read_angular_velocity(source))
              load(parameters, i).angular_velocity = *value;
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            if (load(parameters, i).kind != LoadKind::angular_velocity) return {};
            return format_quantity(load(parameters, i).angular_velocity, dimension);
          }};
}

Key axis_key() {
  return shown_if(
      direction_key(
          "axis", [](Parameters & parameters, std::size_t i) -> auto& { return load(parameters, i).axis; },
          optional("with angular_velocity only"), "direction of the axis of rotation"),
      [](const Parameters& parameters, std::size_t i) {
        return parameters.loads.at(i).kind == LoadKind::angular_velocity;
      });
}

/// A point that belongs to one kind.
Key load_point_key(const char* name, LoadKind kind, std::string help) {
  const Dimension dimension = with_example(length_dimension, "20 mm");
  return {name,
          "length",
          optional(fmt::format("with {} only", name_of(kind))),
          components_form(dimension),
          std::move(help),
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            if (const auto point = read_components(source, dimension, coordinate))
              load(parameters, i).point = point->value;
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            if (load(parameters, i).kind != kind) return {};
            return show_components(load(parameters, i).point, dimension);
          }};
}

Key velocity_gradient_key() {
  const Dimension& dimension = velocity_gradient_dimension;
  const std::string form =
      "three rows of three, such as [[\"0 1/s\", \"0 1/s\", \"0 1/s\"], [\"0 1/s\", \"9 1/s\", \"0 1/s\"], "
      "[\"0 1/s\", \"0 1/s\", \"9 1/s\"]]";
  return {
      name_of(LoadKind::velocity_gradient),
      name_without_article(dimension),
      one_of_kinds(load_kind_names),
      form,
      "velocity at the start, linear in the coordinates: row i has the derivatives of component i; here a "
      "ring expands",
      [=](const Source& source, Parameters& parameters, std::size_t i) {
        load(parameters, i).kind = LoadKind::velocity_gradient;
        const auto rows = read_elements(source, 3, form);
        for (std::size_t row = 0; rows && row < 3; ++row)
          if (const auto derivatives = read_components((*rows)[row], dimension, {-1e12, 1e12}))
            load(parameters, i).gradient[row] = derivatives->value;
      },
      [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
        const BodyLoad& one = load(parameters, i);
        if (one.kind != LoadKind::velocity_gradient) return {};
        std::vector<std::string> rows;
        for (const Vector& row : one.gradient) rows.push_back(show_components(row, dimension));
        return bracketed(rows);
      }};
}

/// Reports a key of another kind, or that a key of this kind is missing.
void check_belongs(const std::string& table, const char* key, LoadKind owner, LoadKind kind,
                   const char* example, Findings& findings) {
  const std::string path = table + "." + key;
  if (kind == owner && !findings.given(path))
    findings.report(path, "the key is missing, but {} requires it; give {} = {}", name_of(owner), key,
                    example);
  else if (kind != owner && findings.given(path))
    findings.report(path, "belongs to {}, not to {}; leave it out", name_of(owner), name_of(kind));
}

void check_history(const BodyLoad& load, const std::string& table, Findings& findings) {
  const std::string path = table + ".history";
  if (!findings.given(path)) return;
  if (is_initial(load.kind))
    findings.report(path, "a velocity at the start does not change with time; leave it out");
  else if (findings.given(table + ".rate"))
    findings.report(path, "is given together with rate; give only one of the two");
  else if (load.kind == LoadKind::angular_velocity &&
           std::ranges::any_of(load.history, [](const auto& point) { return point.second < 0; }))
    findings.report(path, "a centrifugal force never points inwards; give factors of at least 0");
}

}  // namespace

Table load_table() {
  return {
      "load",
      Occurrence::many,
      fmt::format("forces on the whole body, and its velocity at the start; each has exactly one of {}",
                  fmt::join(load_kind_names, ", ")),
      {vector_key(LoadKind::acceleration, acceleration_dimension, any_amount,
                  "force per mass, such as gravity")
           .also_called({"g", "a", "gravity"}),
       vector_key(LoadKind::body_force, body_force_dimension, any_amount, "force per volume")
           .also_called({"b", "f"}),
       angular_velocity_key().also_called({"omega", "speed"}), axis_key(),
       load_point_key("point", LoadKind::angular_velocity, "a point of the axis"),
       vector_key(LoadKind::velocity, value_dimension(BoundaryKind::velocity), any_velocity,
                  "at the start, the same everywhere; several add up; requires time.start = \"rest\"; "
                  "prescribed motions take precedence"),
       velocity_gradient_key(),
       load_point_key("center", LoadKind::velocity_gradient, "where that velocity is zero"), load_rate_key(),
       history_key(
           [](Parameters & parameters, std::size_t i) -> auto& { return load(parameters, i).history; },
           "factors, linear between these times")},
      [](const Parameters& parameters) { return parameters.loads.size(); },
      [](Parameters& parameters) { parameters.loads.emplace_back(); }};
}

void check_loads(const Parameters& parameters, Findings& findings) {
  for (std::size_t i = 0; i < parameters.loads.size(); ++i) {
    const std::string table = load_key(i);
    check_kind(table, "load", load_kind_names, findings);
    if (findings.faulty(table)) continue;
    const BodyLoad& load = parameters.loads[i];
    check_belongs(table, "axis", LoadKind::angular_velocity, load.kind, "[1, 0, 0]", findings);
    check_belongs(table, "point", LoadKind::angular_velocity, load.kind, "[\"0 mm\", \"20 mm\", \"20 mm\"]",
                  findings);
    check_belongs(table, "center", LoadKind::velocity_gradient, load.kind, "[\"0 mm\", \"20 mm\", \"20 mm\"]",
                  findings);
    check_history(load, table, findings);
    if (is_initial(load.kind) && parameters.time.start != Start::rest && !findings.faulty("time.start"))
      findings.report(table + "." + name_of(load.kind),
                      "a velocity at the start requires time.start = \"rest\": quasi-static loading and "
                      "\"equilibrium\" start from an equilibrium, in which nothing moves");
  }
}

}  // namespace crackle::input
