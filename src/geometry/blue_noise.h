// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/random.h"
#include "geometry/body.h"
#include "geometry/crew.h"
#include "geometry/mother_points.h"

#include <functional>
#include <vector>

namespace crackle::geometry {

/// Points with their target spacings.
struct SpacedPoints {
  std::vector<Point> position;
  std::vector<double> spacing;
};

/// The part of a patch where points may lie: where the clearance is at least `margin` local spacings.
struct Room {
  std::function<double(const Point&)> clearance;  ///< distance from the borders, 0 or less beyond them [m]
  double margin;
};

/// True for a rectangle, which has no extent along one axis.
bool is_flat(const Box& region);

/// Makes the distances between points of a patch, which is flat for a face, even: a fixed number of steps
/// with momentum (Polyak 1964) in which points closer than a reach, in proportion to the local spacing, repel
/// each other, and are repelled by fixed ones; like the compressed springs of Persson and Strang (2004), but
/// stiffer at short distances, and between the pairs of cell lists instead of the edges of tessellations;
/// then small random displacements. Points slide along the borders of the room. Only additions,
/// multiplications, divisions and square roots in a fixed order: bitwise equal on every machine and for any
/// crew.
/// @param crew workers that share the steps; null: none. Collective over them
void repel(const SpacingField& spacing, const Patch& patch, const Room& room, const SpacedPoints& fixed,
           SpacedPoints& points, RandomStream& stream, Crew* crew);

/// Points per spacing^2 on a surface and per spacing^3 in the interior, chosen so that the mean edge length
/// of the tessellation is the spacing.
inline constexpr double surface_density = 1.05;
inline constexpr double interior_density = 1.07;

/// Graded blue noise in a patch, which is flat for a face: as many points as the spacing requires in the
/// room, at random and then relaxed (repel). The points keep a distance from each other and from `fixed`
/// ones, and have no preferred directions.
/// @param crew as of repel
std::vector<Point> blue_noise(const SpacingField& spacing, const Patch& patch, const Room& room,
                              const SpacedPoints& fixed, RandomStream stream, Crew* crew);

/// The number of points that blue_noise would give, to a few percent, from a quadrature; stops when it
/// exceeds the limit.
double expected_points(const SpacingField& spacing, const Patch& patch, const Room& room, double limit);

}  // namespace crackle::geometry
