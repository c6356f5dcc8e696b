// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/moving_body.h"
#include "crackle/fracture/breakable_body.h"
#include "crackle/fracture/tuler_butcher.h"

#include <cstdint>
#include <vector>

namespace crackle::dynamics {

/// What breaks at the ends of steps. The criterion gets the stresses at both ends of the last step and a step
/// earlier; nothing is remembered from step to step that the motion does not know, so a checkpoint needs
/// nothing of it.
/// Nothing here is collective.
class BreakingCheck {
public:
  /// The references must outlive the object.
  /// @param motion of `body`, at the start of a phase or where it goes on from a checkpoint
  BreakingCheck(fracture::BreakableBody& body, MovingBody& motion, fracture::TulerButcher& criterion)
      : body_(&body), motion_(&motion), criterion_(&criterion) {}

  /// Notes which tetrahedra are above their strength; due before the first step.
  void start();

  /// Breaks what breaks at the end of the step that the motion has just done. The motion must then release
  /// it.
  /// @param load_time,phase_time of the break records [s]
  void end_step(double load_time, double phase_time);

private:
  double largest_principal(const mechanics::Symmetric& strain) const;

  fracture::BreakableBody* body_;
  MovingBody* motion_;
  fracture::TulerButcher* criterion_;
  std::vector<std::int32_t> over_;  // above the strength at the end of the last step; unbroken, ascending
  std::vector<std::int32_t> candidates_;
};

}  // namespace crackle::dynamics
