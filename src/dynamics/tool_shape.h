// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/vector.h"
#include "input/tool.h"

#include <Eigen/Core>

namespace crackle::dynamics {

/// The surface of a rigid tool, seen from a point.
struct ToolSurface {
  double distance = 0;  ///< of the point from the surface; negative inside [m]
  Vector normal{};      ///< unit vector out of the tool at the nearest point of its surface
};

/// @param p point in the tool's frame: relative to the tool's point `at` [m]
ToolSurface surface_from(const input::Tool& tool, const Vector& p);

/// The largest section of a tool along its sides; infinite for a plane or an endless
/// cylinder [m^2].
double largest_section(const input::Tool& tool);

/// A point of a tool with ends that is as far from its middle as any, or slightly beyond a rounded edge, in
/// the tool's frame [m].
Vector farthest_point(const input::Tool& tool);

/// The inertia of a tool that turns, with its mass evenly in its volume, about its middle [kg m^2].
Eigen::Matrix3d moment_of_inertia(const input::Tool& tool);

/// The impulse on a point of the surface of a tool with a mass over the velocity that it gives this point, at
/// least; its mass, unless it turns [kg].
double least_mass(const input::Tool& tool);

}  // namespace crackle::dynamics
