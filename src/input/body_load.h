// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "common/vector.h"
#include "input/profile.h"

#include <array>

namespace crackle::input {

/// The quantity that a [[load]] prescribes for all points of the body.
enum class LoadKind {
  acceleration,       ///< force per mass [m/s^2]
  body_force,         ///< force per volume [N/m^3]
  angular_velocity,   ///< centrifugal force on a body at rest in a rotating frame, per mass [m/s^2]
  velocity,           ///< at the start [m/s]
  velocity_gradient,  ///< velocity at the start, linear in the coordinates [m/s]
};

/// By LoadKind, as the keys of [[load]].
inline constexpr std::array load_kind_names{"acceleration", "body_force", "angular_velocity", "velocity",
                                            "velocity_gradient"};

constexpr const char* name_of(LoadKind kind) {
  return load_kind_names[index(kind)];
}

/// True for a velocity at the start, which is not a force.
constexpr bool is_initial(LoadKind kind) {
  return kind == LoadKind::velocity || kind == LoadKind::velocity_gradient;
}

/// A force on every point of the body, or an initial velocity.
///
/// At time t an acceleration or body force is value + rate t, or value times the factor of the history. The
/// load of a rotation is constant or has a history; its factors multiply the force, not the angular velocity.
struct BodyLoad {
  LoadKind kind = LoadKind::acceleration;
  Vector value{};  ///< of an acceleration, body force or velocity
  Vector rate{};
  double angular_velocity = 0;       ///< [rad/s]
  Vector axis{};                     ///< direction of the axis of rotation, of any length
  Vector point{};                    ///< on that axis, or where the velocity of a gradient is zero [m]
  std::array<Vector, 3> gradient{};  ///< derivatives of the components of the velocity [1/s]
  FactorTable history = {};

  /// The prescribed quantity at a point, without rate and history; affine in the coordinates.
  Vector at(const Vector& p) const;
};

}  // namespace crackle::input
