// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/random.h"
#include "crackle/geometry/body.h"
#include "crackle/geometry/mother_points.h"

#include "repulsion.h"

#include <functional>
#include <vector>

namespace crackle::geometry {

/// Points per spacing^2 on a surface and per spacing^3 in the interior, chosen so that the mean edge length
/// of the tessellation is the spacing.
inline constexpr double surface_density = 1.05;
inline constexpr double interior_density = 1.07;

/// Graded blue noise in a patch, which is flat for a face: as many points as the spacing requires in the
/// room, at random and then relaxed (repel). The points keep a distance from each other and from `fixed`
/// ones, and have no preferred directions.
std::vector<Point> blue_noise(const SpacingField& spacing, const Patch& patch, const Room& room,
                              const SpacedPoints& fixed, RandomStream stream);

/// The number of points that blue_noise would give, to a few percent, from a quadrature; stops when it
/// exceeds the limit.
double expected_points(const SpacingField& spacing, const Patch& patch, const Room& room, double limit);

}  // namespace crackle::geometry
