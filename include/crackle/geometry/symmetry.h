// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/geometry/point.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <vector>

namespace crackle::geometry {

/// The image of a point when coordinate i is reflected in the middle of the box wherever bit i of `axes` is
/// set: two bits together are a half-turn, three a reflection in the centre. The image of a point on a plane
/// of the body lies on the image of this plane bit by bit, if that is one of the body's.
Point reflected(const Body& body, std::uint8_t axes, const Point& p);

/// Every `axes` for which `reflected` maps the body on itself, to 1e-12 of its largest size; ascending, so
/// that the first is 0. A box has all eight, a plate with two anti-symmetric notches 0, x, yz and xyz.
std::vector<std::uint8_t> symmetries(const Body& body);

/// Those of them that map the regions of the mesh on regions of the same spacing too.
std::vector<std::uint8_t> symmetries(const Body& body, const input::Mesh& mesh);

}  // namespace crackle::geometry
