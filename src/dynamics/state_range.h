// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/moving_body.h"
#include "crackle/mechanics/fixed_point_scale.h"

namespace crackle::dynamics {

/// What stretches, velocities and forces a dynamic phase can be expected to reach. The stress that drives
/// it is the larger of the one in the starting state and the one that loads and prescribed motions send out,
/// which breaking limits to the strength; a wave of that stress moves the material with stress / impedance.
/// Free flight, and generous factors for focusing, are added; whatever exceeds the range is noticed and
/// reported, never wrapped. Collective; equal bits for any number of ranks.
mechanics::StateRange expected_range(const MotionContext& context, double load_time, double duration,
                                     const MotionState& state);

}  // namespace crackle::dynamics
