// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/moving_body.h"
#include "crackle/fracture/breakable_body.h"
#include "crackle/fracture/criterion.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// What breaks at the ends of steps. The criterion gets the stresses at both ends of the last step and a step
/// earlier; nothing is remembered from step to step that the motion does not know, so a checkpoint needs
/// nothing of it.
/// Nothing here is collective.
class BreakingCheck {
public:
  /// The references must outlive the object.
  /// @param motion of `body`, at the start of a phase or where it continues from a checkpoint
  BreakingCheck(const fracture::BreakableBody& body, MovingBody& motion, fracture::Criterion& criterion)
      : body_(&body), motion_(&motion), criterion_(&criterion) {}

  /// Notes which tetrahedra are above their strength; due before the first step.
  void start();

  /// The tetrahedra that break at the end of the step that the motion has just done, ascending. The body must
  /// release them before the next step.
  std::span<const std::int32_t> end_step();

private:
  double stress(const mechanics::Symmetric& strain) const {
    return criterion_->stress()(body_->elasticity()(strain));
  }

  const fracture::BreakableBody* body_;
  MovingBody* motion_;
  fracture::Criterion* criterion_;
  std::vector<std::int32_t> over_;  // above the strength at the end of the last step; unbroken, ascending
  std::vector<std::int32_t> candidates_, breaking_;
};

}  // namespace crackle::dynamics
