// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/vector.h"

#include "facets.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace crackle::solid {

/// A closed surface of triangles, counter-clockwise seen from outside.
struct Surface {
  std::vector<Vector> points;
  std::vector<std::array<std::int32_t, 3>> facets;
  std::vector<int> group;  ///< of each facet, or -1
};

/// "(1, 2.5, 3) mm"
std::string show_place(const Vector& p, const std::string& unit);

/// The surface of a body in one piece, perhaps with cavities.
/// @param facets whose points are separate and whose polygons have an area
/// @throws std::runtime_error unless it is one; the message names the place
Surface make_surface(Facets facets, const std::string& unit);

}  // namespace crackle::solid
