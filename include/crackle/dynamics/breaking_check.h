// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/moving_body.h"

#include <cstdint>
#include <memory>
#include <span>

namespace crackle::dynamics {

/// What breaks at the ends of steps. The criterion gets the stresses at both ends of the last step and a step
/// earlier. Nothing is remembered that the motion does not know, from one step to the next, or else beyond
/// the steps whose number `free_interval` divides: there a checkpoint needs nothing of it.
class BreakingCheck {
public:
  static constexpr std::int64_t free_interval = 8;

  BreakingCheck() = default;
  virtual ~BreakingCheck() = default;
  BreakingCheck(const BreakingCheck&) = delete;
  BreakingCheck& operator=(const BreakingCheck&) = delete;

  /// Notes which tetrahedra are above their strength; due before the first step. Local.
  virtual void start() = 0;

  /// The local tetrahedra that break at the end of the step that the motion has just done, ascending. The
  /// body must release them before the next step. The step's number counts from 1. Collective where the
  /// context averages the stress; what it throws on one rank, it throws when its messages are complete.
  virtual std::span<const std::int32_t> end_step(std::int64_t step) = 0;
};

/// That of the context's criterion, which sees the tetrahedra's own stress or the context's average.
/// @param context, motion must outlive the result
/// @param motion of the context's body, at the start of a phase or where it continues from a checkpoint
std::unique_ptr<BreakingCheck> make_breaking_check(const MotionContext& context, MovingBody& motion);

}  // namespace crackle::dynamics
