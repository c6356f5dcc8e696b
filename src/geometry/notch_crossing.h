// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/geometry/point.h"

#include <array>
#include <span>

namespace crackle::geometry {

/// Where a tetrahedron lies with respect to the notches.
enum class Place {
  solid,     ///< its interior is clear of all slots
  cavity,    ///< inside the closed slot of one notch
  crossing,  ///< neither: it reaches through a wall or a tip
};

/// Exact: decided by comparisons and exact orientation tests, without tolerances.
/// @param corners of a tetrahedron inside the box of the body
Place place(std::span<const SlotSection> sections, const std::array<Point, 4>& corners);

}  // namespace crackle::geometry
