// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/moving_body.h"
#include "crackle/input/parameters.h"

namespace crackle::dynamics {

/// Gives owned nodes the input's velocity at the start. Components with a prescribed motion stay at rest:
/// their drive gives them their velocity. Local.
void set_initial_velocity(const MotionContext& context, const input::Parameters& parameters,
                          MotionState& state);

}  // namespace crackle::dynamics
