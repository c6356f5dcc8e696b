// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/moving_body.h"

#include <cstdint>
#include <memory>
#include <span>

namespace crackle::dynamics {

/// Decides which tetrahedra break at the end of each step. The criterion gets the stresses at both ends of
/// the last step and one step earlier. No state that cannot be recomputed from the motion is kept from one
/// step to the next, or beyond steps whose number is a multiple of `free_interval`; checkpoints at those
/// steps need no data of the check.
class BreakingCheck {
public:
  static constexpr std::int64_t free_interval = 8;

  BreakingCheck() = default;
  virtual ~BreakingCheck() = default;
  BreakingCheck(const BreakingCheck&) = delete;
  BreakingCheck& operator=(const BreakingCheck&) = delete;

  /// Records which tetrahedra are above their strength; call before the first step. Local.
  virtual void start() = 0;

  /// The local tetrahedra that break at the end of the step just completed, ascending. The body must release
  /// them before the next step. Steps count from 1. Collective if the stress is averaged, over balls or
  /// around nodes; a rank throws only after its communication is complete.
  virtual std::span<const std::int32_t> end_step(std::int64_t step) = 0;
};

/// The check for the context's criterion, which uses each tetrahedron's own stress, that and means around
/// nodes, or the context's average.
/// @param context, motion must outlive the result
/// @param motion of the context's body, at the start of a phase or restored from a checkpoint
std::unique_ptr<BreakingCheck> make_breaking_check(const MotionContext& context, MovingBody& motion);

}  // namespace crackle::dynamics
