// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/input/parameters.h"

#include <string>
#include <vector>

namespace crackle::dynamics {

/// How many times too stiff a plate of linear tetrahedra is when it bends out of its plane.
/// @param cells spacings through the thickness
double bending_stiffness_ratio(double cells);

/// How many times too stiff a plate of linear tetrahedra is when it bends in its plane, with ten spacings
/// over its height: nearly incompressible tetrahedra lock.
double locking_stiffness_ratio(double poisson_ratio);

/// The load at which a smooth beam of given strength breaks in bending, over the load at Poisson's ratio 0.2:
/// the pressure oscillates from tetrahedron to tetrahedron, the more so the less compressible they are.
double locking_load_ratio(double poisson_ratio);

/// Warnings about values that hardly anyone means (input::plausibility_warnings), and about what the mesh
/// cannot represent of this body and these conditions: one or two sentences each, with the size of the error
/// and what to do about it.
std::vector<std::string> model_warnings(const input::Parameters& parameters, const geometry::Body& body);

/// The same for quasi-static loading whose load rises to the first break within a few transits of a wave, so
/// that inertia matters; empty where it does not.
/// @param first_break_time since the loading began [s]
std::string fast_loading_warning(const input::Parameters& parameters, double first_break_time);

}  // namespace crackle::dynamics
