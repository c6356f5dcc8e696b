// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/random.h"
#include "crackle/geometry/body.h"

#include <cstdint>

namespace crackle::geometry {

/// A point uniformly distributed within `radius` of `centre` in the directions in which that can move: in a
/// ball, a disc or a segment. Positions outside the body or on another face are drawn again.
Point displaced(const Body& body, const Point& centre, std::uint8_t movable, double radius,
                RandomStream stream);

}  // namespace crackle::geometry
