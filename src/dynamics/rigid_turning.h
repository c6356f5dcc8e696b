// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/vector.h"

#include <Eigen/Geometry>

#include <array>

namespace crackle::dynamics {

/// A rigid body that turns about its centroid, freely or about some axes of space only. Its angular momentum
/// about these changes by moments alone.
class RigidTurning {
public:
  /// @param inertia about the centroid, at the start [kg m^2]
  /// @param free axes of space about which it turns
  /// @param spin at the start; about other axes not read [rad/s]
  RigidTurning(const Eigen::Matrix3d& inertia, const std::array<bool, 3>& free, const Vector& spin);

  const Vector& spin() const { return spin_; }  ///< angular velocity [rad/s]
  /// The rotation from the place at the start, once the body has gone on at its spin. @param duration [s]
  Eigen::Quaterniond orientation_after(double duration) const;

  /// One step of the midpoint rule: reversible, of second order, free of drift in energy.
  /// @param impulse of moments [N m s]
  /// @return the mean spin, at which the impulse has done its work [rad/s]
  Vector turn(const Vector& impulse, double duration);

  /// Orientation (w, x, y, z) and angular momentum.
  using State = std::array<double, 7>;
  State state() const;
  void restore(const State& state);

private:
  Vector spin_of(const Eigen::Quaterniond& orientation, const Vector& momentum) const;

  Eigen::Matrix3d inertia_;
  std::array<bool, 3> free_;
  Eigen::Quaterniond orientation_ = Eigen::Quaterniond::Identity();
  Vector momentum_{};  // about the free axes [kg m^2/s]
  Vector spin_{};
};

/// A vector of the body at the start, in space.
Vector turned(const Eigen::Quaterniond& orientation, const Vector& vector);

}  // namespace crackle::dynamics
