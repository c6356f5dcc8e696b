// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cracks/crack_surface.h"
#include "input/section.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::cracks {

/// Where one crack crosses a plane.
struct PlaneTrace {
  std::int32_t plane;        ///< its number
  std::int32_t crack;        ///< index into CrackSurface::cracks
  double length;             ///< of the facets' lines in the plane [m]
  geometry::Point position;  ///< mean, by length [m]
  double first_time;         ///< as CrackFacet::time, of the facet in the plane that opened first [s]
};

/// The traces of all cracks in all planes that they cross; by plane, then by crack.
std::vector<PlaneTrace> plane_traces(const CrackSurface& surface,
                                     std::span<const input::SectionPlane> planes);

}  // namespace crackle::cracks
