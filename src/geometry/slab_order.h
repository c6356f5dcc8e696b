// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/mother_points.h"

namespace crackle::geometry {

/// The points in slabs of about one local spacing across the longest edge of the body, each slab in strips
/// across the second longest one, each strip along the shortest: neighbours in space get nearby numbers.
MotherPoints in_slab_order(const MotherPoints& points, const Point& size);

}  // namespace crackle::geometry
