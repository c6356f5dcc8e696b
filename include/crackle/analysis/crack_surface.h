// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/fracture/break_record.h"
#include "crackle/geometry/body.h"
#include "crackle/geometry/realization.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::analysis {

/// One opened dual facet: the quadrilateral edge midpoint, face centroid, tetrahedron centroid, face
/// centroid.
struct CrackFacet {
  std::array<geometry::Point, 4> corner;  ///< in order round the quadrilateral [m]
  double area;                            ///< [m^2]
  double time;  ///< since the onset of the last dynamic phase; negative before it [s]
  std::int64_t tetrahedron;
  std::int32_t crack;  ///< sample-local crack id: index into CrackSurface::cracks
};

/// A connected crack. Broken tetrahedra that share an edge are connected; in order of breaking, a tetrahedron
/// joins the crack it touches first, and a crack belongs to the notch that it touched first.
struct Crack {
  std::int32_t notch;  ///< notch it started at, or -1
  double area;         ///< [m^2]
  double first_time;   ///< [s]
  double last_time;    ///< [s]
};

struct CrackSurface {
  std::vector<CrackFacet> facets;  ///< in order of breaking
  std::vector<Crack> cracks;
  double area() const;  ///< sum over all facets [m^2]
};

/// The crack surface: for every break the dual facets of its most loaded cut.
/// @param onset_time load time that facet times are counted from [s]
CrackSurface make_crack_surface(const geometry::Body& body, const geometry::Realization& realization,
                                std::span<const fracture::Break> breaks, double onset_time);

}  // namespace crackle::analysis
