// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/random.h"
#include "crackle/geometry/body.h"

#include <cstdint>

namespace crackle::geometry {

/// A random point, uniform within `radius` of `centre` in its movable directions: in a ball, a disc or a
/// segment. Positions outside the body or on another face are redrawn.
Point displaced(const Body& body, const Point& centre, std::uint8_t movable, double radius,
                RandomStream stream);

}  // namespace crackle::geometry
