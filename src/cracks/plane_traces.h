// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "cracks/crack_surface.h"
#include "input/section.h"

#include <array>
#include <cstddef>
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

/// Perpendicular unit vectors along a plane: axes of the coordinates if they lie in it, the others level with
/// z or rising with it.
std::array<Vector, 2> axes_along(const input::SectionPlane& plane);

/// Where several cracks cross a plane together; NaN if none does.
struct StartTrace {
  double length = 0;           ///< of all facets' lines in the plane [m]
  double time = not_a_number;  ///< when the first one came there, as CrackFacet::time [s]
  /// Mean by length: distances from the plane's point along its axes_along [m].
  double along = not_a_number, across = not_a_number;
};

/// Rows for each plane in start_traces: crack starts, cracks without a start, all cracks.
inline std::size_t n_trace_rows(std::size_t n_starts) {
  return n_starts + 2;
}

/// The traces of each crack start; planes x n_trace_rows, row-major.
std::vector<StartTrace> start_traces(const CrackSurface& surface, std::span<const input::SectionPlane> planes,
                                     std::size_t n_starts);

}  // namespace crackle::cracks
