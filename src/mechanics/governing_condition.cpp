// SPDX-License-Identifier: GPL-3.0-or-later
#include "mechanics/governing_condition.h"

#include "common/index.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <variant>

namespace crackle::mechanics {

namespace {

using input::BoundaryKind;

/// The part of a boundary condition or body force in the load of the machine.
struct Drive {
  std::string name;
  Vector value, rate;
  input::FactorTable history;
  bool has_quantity, is_velocity, has_direction;
};

Drive drive_of(const input::Boundary& condition) {
  return {condition.name,
          condition.value,
          condition.rate,
          condition.history,
          input::has_quantity(condition.kind),
          condition.kind == BoundaryKind::velocity,
          input::traits(condition.kind).form == input::QuantityForm::vector};
}

Drive drive_of(const input::BodyLoad& load) {
  // The forces of a rotation point in all directions; as those of a pressure they push.
  if (load.kind == input::LoadKind::angular_velocity)
    return {{}, {std::abs(load.angular_velocity), 0, 0}, {}, load.history, true, false, false};
  return {{}, load.value, load.rate, load.history, true, false, true};
}

Drive drive_of(const input::Tool& tool, std::size_t number) {
  const bool is_velocity = tool.velocity && tool.gives_velocity();
  return {name_of(tool, number), tool.given(), tool.rate, tool.history, true, is_velocity, true};
}

bool drives(const Drive& condition) {
  return condition.has_quantity && (condition.value != Vector{} || condition.rate != Vector{});
}

bool changes(const Drive& condition) {
  return drives(condition) &&
         (condition.rate != Vector{} || !condition.history.empty() || condition.is_velocity);
}

/// The index of the condition that drives the body.
std::optional<std::size_t> driver(const std::vector<Drive>& conditions) {
  for (const auto& is_meant : {changes, drives}) {
    const auto found = std::ranges::find_if(conditions, is_meant);
    if (found != conditions.end()) return static_cast<std::size_t>(found - conditions.begin());
  }
  return std::nullopt;
}

Vector drive_direction(const Drive& condition) {
  if (!drives(condition)) return {};
  const bool is_by_value =
      condition.rate == Vector{} || (condition.is_velocity && condition.value != Vector{});
  Vector direction = is_by_value ? condition.value : condition.rate;
  // Scale first, since squares of very small numbers underflow.
  double largest = 0;
  for (const double component : direction) largest = std::max(largest, std::abs(component));
  for (double& component : direction) component /= largest;
  const double length = norm(direction);
  const auto factor =
      std::ranges::find_if(condition.history, [](const auto& point) { return point.second != 0; });
  const double sign = factor != condition.history.end() && factor->second < 0 ? -1 : 1;
  for (double& component : direction) component *= sign / length;
  return direction;
}

}  // namespace

std::vector<GoverningCondition> governing_conditions(const input::Model& model) {
  std::vector<Drive> conditions;
  for (const auto& condition : model.boundaries) conditions.push_back(drive_of(condition));
  for (const auto& load : model.body_forces()) conditions.push_back(drive_of(load));
  for (std::size_t i = 0; i < model.tools.size(); ++i) conditions.push_back(drive_of(model.tools[i], i));
  const auto drive = driver(conditions);
  std::optional<std::size_t> first = drive;
  const auto& governing = model.governing;
  if (const auto* const number = std::get_if<int>(&governing)) first = index(*number);
  if (const auto* const name = std::get_if<std::string>(&governing))
    first = static_cast<std::size_t>(std::ranges::find(conditions, *name, &Drive::name) - conditions.begin());
  if (!first) return {};
  const Vector along =
      drive && conditions[*drive].has_direction ? drive_direction(conditions[*drive]) : Vector{};
  const std::string& name = conditions.at(*first).name;
  std::vector<GoverningCondition> group;
  for (std::size_t i = 0; i < conditions.size(); ++i) {
    if (i != *first && (name.empty() || conditions[i].name != name)) continue;
    GoverningCondition one{.condition = static_cast<int>(i), .is_support = !drives(conditions[i])};
    one.direction = drive_direction(conditions[i]);
    if (one.is_support)
      for (std::size_t c = 0; c < 3; ++c) one.direction[c] = -along[c];
    group.push_back(one);
  }
  return group;
}

}  // namespace crackle::mechanics
