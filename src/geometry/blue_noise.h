// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/random.h"
#include "crackle/geometry/body.h"
#include "crackle/geometry/mother_points.h"

#include <functional>
#include <vector>

namespace crackle::geometry {

/// Points with their target spacings.
struct SpacedPoints {
  std::vector<Point> position;
  std::vector<double> spacing;
};

/// Points per spacing^2 on a surface and per spacing^3 in the interior, chosen so that the mean edge length
/// of the tessellation is the spacing.
inline constexpr double surface_density = 1.05;
inline constexpr double interior_density = 1.07;

/// Graded blue noise in a patch, which is flat for a face: as many points as the spacing requires in the part
/// of the patch that `accepts`, by weighted sample elimination (Yuksel 2015) from random candidates of the
/// required density. The points keep a distance from each other and from `fixed` ones, and have no preferred
/// directions.
std::vector<Point> blue_noise(const SpacingField& spacing, const Patch& patch,
                              const std::function<bool(const Point&, double spacing)>& accepts,
                              const SpacedPoints& fixed, RandomStream stream);

/// The number of points that blue_noise would give, to a few percent, from a quadrature; stops when it
/// exceeds the limit.
double expected_points(const SpacingField& spacing, const Patch& patch,
                       const std::function<bool(const Point&, double spacing)>& accepts, double limit);

}  // namespace crackle::geometry
