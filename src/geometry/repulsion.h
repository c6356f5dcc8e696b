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
/// multiplications, divisions and square roots in a fixed order: bitwise equal on every machine.
void repel(const SpacingField& spacing, const Patch& patch, const Room& room, const SpacedPoints& fixed,
           SpacedPoints& points, RandomStream& stream);

}  // namespace crackle::geometry
