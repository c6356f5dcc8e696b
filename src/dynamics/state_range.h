// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/moving_body.h"
#include "mechanics/fixed_point_scale.h"

#include "terms.h"

namespace crackle::dynamics {

/// Expected stretches, velocities and forces in a dynamic phase. The driving stress is the larger of that in
/// the starting state and that of the waves that the terms emit, limited by the strength;
/// a wave of this stress moves the material with stress / impedance. Free flight and generous factors for
/// focusing are added; out-of-range values are detected and reported, never wrapped. Collective; bitwise
/// equal for any number of ranks.
mechanics::StateRange expected_range(const MotionContext& context, const Terms& terms, double load_time,
                                     double duration, const MotionState& state);

}  // namespace crackle::dynamics
