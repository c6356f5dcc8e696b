// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/realization.h"
#include "crackle/input/parameters.h"

namespace crackle::dynamics {

/// Part of the stable step that `step = "auto"` takes.
inline constexpr double automatic_step_fraction = 0.9;

/// The largest time step that the chosen integrator takes on the intact body without becoming unstable [s],
/// from the largest eigenfrequency of M^-1 K with its constraints. Not collective.
double stable_step(const input::Parameters& parameters, const geometry::Realization& realization);

}  // namespace crackle::dynamics
