// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/vector.h"
#include "input/profile.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace crackle::input {

enum class ToolShape { plane, cylinder, sphere, box };
/// As spelled in the input.
inline constexpr std::array tool_shape_names{"plane", "cylinder", "sphere", "box"};
/// Ways in which a tool may move, as spelled in the input: along axes, and about them.
inline constexpr std::array tool_freedoms{"x", "y", "z", "turn x", "turn y", "turn z"};

/// A rigid body beside the specimen, which it touches: a projectile, a roller, a platen.
struct Tool {
  std::string name;  ///< empty: see name_of()
  ToolShape shape = ToolShape::sphere;
  Vector at{};               ///< a point of a plane, the middle of another shape [m]
  Vector axis{};             ///< normal of a plane, towards the body, or axis of a cylinder; of any length
  double radius = 0;         ///< of a cylinder or sphere [m]
  std::vector<double> size;  ///< edges of a box along x, y and z; length of a cylinder, if it has ends [m]
  double rounding = 0;       ///< radius of the edges of a box or of a cylinder's ends [m]
  double mass = 0;           ///< [kg]; 0: it moves as prescribed
  /// At the start with a mass, otherwise prescribed [m/s].
  std::optional<Vector> velocity = {};
  std::optional<Vector> angular_velocity = {};  ///< at the start, with a mass [rad/s]
  std::optional<Vector> displacement = {};      ///< prescribed [m]
  std::optional<Vector> force = {};             ///< on the tool [N]
  Vector rate{};                                ///< of what is prescribed, per time
  FactorTable history = {};                     ///< of what is prescribed, as of a Boundary
  /// The tool_freedoms that it has, with a mass; empty: it moves along all axes.
  std::optional<std::array<bool, 6>> free = {};
  std::optional<double> friction = {};  ///< coefficient

  bool has_mass() const { return mass > 0; }
  /// The motion or force that is given, besides the velocity of a mass: a displacement, else a force, else a
  /// velocity.
  Vector given() const { return displacement.value_or(force.value_or(velocity.value_or(Vector{}))); }
  bool gives_velocity() const { return !displacement && !force; }
  /// Moves by the forces on it.
  bool is_driven_by_force() const { return has_mass() || force.has_value(); }
  bool moves_along(int axis_number) const { return !free || (*free)[static_cast<std::size_t>(axis_number)]; }
  /// Axes about which it can turn.
  std::array<bool, 3> turning() const {
    return free ? std::array{(*free)[3], (*free)[4], (*free)[5]} : std::array<bool, 3>{};
  }
  bool turns() const { return turning() != std::array<bool, 3>{}; }
};

/// Its name, or "tool-0" by its number.
std::string name_of(const Tool& tool, std::size_t number);

}  // namespace crackle::input
