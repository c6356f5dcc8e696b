// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/rigid_turning.h"

namespace crackle::dynamics {

namespace {

/// Iterations for the orientation in the middle of a step, where the body turns by a small angle.
constexpr int n_iterations = 4;

/// Cayley's map needs no function whose last bits depend on the C library.
Eigen::Quaterniond turned_by(const Eigen::Quaterniond& orientation, const Vector& angle) {
  const Eigen::Quaterniond way(1, 0.5 * angle[0], 0.5 * angle[1], 0.5 * angle[2]);
  return (way.normalized() * orientation).normalized();
}

}  // namespace

RigidTurning::RigidTurning(const Eigen::Matrix3d& inertia, const std::array<bool, 3>& free,
                           const Vector& spin)
    : inertia_(inertia), free_(free) {
  const auto along_free = [&](const Vector& vector) -> Vector {
    return {free[0] ? vector[0] : 0, free[1] ? vector[1] : 0, free[2] ? vector[2] : 0};
  };
  const Eigen::Vector3d momentum = inertia * Eigen::Vector3d(along_free(spin).data());
  momentum_ = along_free({momentum[0], momentum[1], momentum[2]});
  spin_ = spin_of(orientation_, momentum_);
}

Vector RigidTurning::spin_of(const Eigen::Quaterniond& orientation, const Vector& momentum) const {
  const Eigen::Matrix3d turn = orientation.toRotationMatrix();
  Eigen::Matrix3d inertia = turn * inertia_ * turn.transpose();
  for (Eigen::Index i = 0; i < 3; ++i)
    if (!free_[static_cast<std::size_t>(i)]) {  // bearings take any moment
      inertia.row(i).setZero();
      inertia.col(i).setZero();
      inertia(i, i) = 1;
    }
  const Eigen::Vector3d spin = inertia.llt().solve(Eigen::Vector3d(momentum.data()));
  return {spin[0], spin[1], spin[2]};
}

Eigen::Quaterniond RigidTurning::orientation_after(double duration) const {
  return turned_by(orientation_, duration * spin_);
}

Vector RigidTurning::turn(const Vector& impulse, double duration) {
  Vector change{};
  for (std::size_t i = 0; i < 3; ++i)
    if (free_[i]) change[i] = impulse[i];
  const Vector momentum = momentum_ + 0.5 * change;
  Vector spin = spin_of(orientation_, momentum);
  for (int k = 0; k < n_iterations; ++k)
    spin = spin_of(turned_by(orientation_, 0.5 * duration * spin), momentum);
  // In two halves, so that the way back is the same.
  for (int half = 0; half < 2; ++half) orientation_ = turned_by(orientation_, 0.5 * duration * spin);
  momentum_ = momentum_ + change;
  spin_ = spin_of(orientation_, momentum_);
  return spin;
}

RigidTurning::State RigidTurning::state() const {
  const auto& q = orientation_;
  return {q.w(), q.x(), q.y(), q.z(), momentum_[0], momentum_[1], momentum_[2]};
}

void RigidTurning::restore(const State& state) {
  orientation_ = Eigen::Quaterniond(state[0], state[1], state[2], state[3]);
  momentum_ = {state[4], state[5], state[6]};
  spin_ = spin_of(orientation_, momentum_);
}

Vector turned(const Eigen::Quaterniond& orientation, const Vector& vector) {
  const Eigen::Vector3d way = orientation * Eigen::Vector3d(vector.data());
  return {way[0], way[1], way[2]};
}

}  // namespace crackle::dynamics
