// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/moving_body.h"
#include "fracture/break_record.h"

#include "step_failure.h"

#include <cstdint>
#include <span>

namespace crackle::dynamics {

/// Takes the stiffness of breaking tetrahedra from a body in motion: the released energy goes to the body's
/// records, from which the energy account sums it, and the criterion and the motion learn of the change.
class BreakRelease {
public:
  /// The context's members and the motion must outlive the object.
  /// @param load_time time of the load curves at the start of the phase [s]
  BreakRelease(const MotionContext& context, MovingBody& motion, double load_time)
      : context_(context), motion_(&motion), load_time_(load_time) {}

  /// Releases tetrahedra, continues releases under way, releases edges of others by the bridging rule, and
  /// updates the strengths near cracks, between two steps. Collective.
  /// @param breaking local tetrahedra, from the breaking check
  /// @param phase_time since the start of the phase [s]
  /// @param failure receives a failure of this rank
  /// @return the local tetrahedra whose stiffness has changed; valid until the next call
  std::span<const std::int32_t> apply(std::span<const std::int32_t> breaking, double phase_time,
                                      StepFailure& failure);

  /// Restores the releases of a phase up to its checkpoint; call before the motion is restored. Local.
  /// @param phase_time of the checkpoint [s]
  void restore(const fracture::Releases& releases, double phase_time);

  /// Updates the strengths near broken tetrahedra, see fracture::FractureLaw::follow_cracks(). Collective; a
  /// rank throws only after its communication is complete.
  /// @param phase_time since the start of the phase [s]; infinity: at its start, whatever broke before
  void update_strengths(double phase_time);

private:
  MotionContext context_;
  MovingBody* motion_;
  double load_time_;
};

}  // namespace crackle::dynamics
