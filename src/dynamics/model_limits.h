// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"
#include "input/study.h"

#include <string>
#include <vector>

namespace crackle::dynamics {

/// Factor by which a plate of linear tetrahedra is too stiff in out-of-plane bending.
/// @param cells spacings through the thickness
double bending_stiffness_ratio(double cells);

/// Factor by which a plate of linear tetrahedra with ten spacings over its height is too stiff in in-plane
/// bending: nearly incompressible tetrahedra lock.
double locking_stiffness_ratio(double poisson_ratio);

/// The bending load at which a smooth beam of given strength breaks, relative to that at Poisson's ratio 0.2:
/// the pressure oscillates between tetrahedra, increasingly so towards incompressibility.
double locking_load_ratio(double poisson_ratio);

/// Warnings about implausible values (input::plausibility_warnings) and about limits of the mesh for this
/// body and these conditions: one or two sentences each, with the size of the error and advice.
std::vector<std::string> model_warnings(const input::Study& study, const geometry::Body& body);

/// The same for quasi-static loading that reaches the first break within a few wave transits, so that inertia
/// matters; empty otherwise.
/// @param first_break_time since the loading began [s]
/// @param transit of a wave along the body, see wave_transit; 0: not known [s]
std::string fast_loading_warning(input::Start start, double first_break_time, double transit);

/// The same for quasi-static loading that moves the body beyond small strains; empty otherwise.
/// @param size of the body [m]
/// @param displacement of the machine at the peak load [m]; may be NaN
std::string large_displacement_warning(input::Start start, const Vector& size, double displacement);

}  // namespace crackle::dynamics
