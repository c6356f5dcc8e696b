// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fracture/break_record.h"
#include "geometry/body.h"
#include "geometry/realization.h"
#include "mechanics/elasticity.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::cracks {

/// One opened dual facet: the plane, convex quadrilateral edge midpoint, face centroid, tetrahedron centroid,
/// face centroid.
struct CrackFacet {
  std::array<geometry::Point, 4> corner;  ///< in order around the quadrilateral [m]
  double area;                            ///< [m^2]
  double time;  ///< opening time since the start of the last dynamic phase; zero or negative before it [s]
  std::int64_t tetrahedron;
  std::int32_t crack;  ///< sample-local crack id: index into CrackSurface::cracks
};

/// Local mesh spacing at a facet: the length of the edge opposite to the one that the facet cuts [m].
double local_spacing(const CrackFacet& facet);

/// A connected crack.
///
/// Broken tetrahedra that share an edge are connected. In order of breaking, a tetrahedron joins the cracks
/// it touches and merges them, with one exception: cracks of different starts remain separate, and the
/// tetrahedron at which they meet joins the one whose latest break it touches (the running one). A crack
/// belongs to the crack start that it touched first, either with a tetrahedron that has a node claimed by the
/// start (geometry::CrackStart), or by joining a crack of that start. A crack that touches no start belongs
/// to the free surface, if that is a crack start of the body.
///
/// Where a crack runs into a hole, or meets a crack of that hole, all cracks of the hole continue it and
/// belong to its start: one crack through a hole, whichever side of the hole opened first.
struct Crack {
  std::int32_t start;      ///< number of the crack start that it belongs to, or -1
  double area;             ///< [m^2]
  double first_time;       ///< [s]
  double last_time;        ///< [s]
  std::int32_t hole = -1;  ///< number of the hole that it leaves, continuing another crack; -1 for others

  /// Number of the crack start that it touched first, or -1.
  std::int32_t origin() const { return hole >= 0 ? hole : start; }
};

/// The first encounter of a hole with the crack that those from the hole continue.
struct HoleEntry {
  std::int32_t hole;   ///< its number as a crack start
  std::int32_t start;  ///< that the crack belongs to
  std::int32_t crack;  ///< its number; -1 if a crack from the hole reached the start instead
};

struct CrackSurface {
  std::vector<CrackFacet> facets;    ///< in order of breaking
  std::vector<Crack> cracks;         ///< in order of their first break
  std::vector<HoleEntry> entries;    ///< in order of breaking; not stored in sample files
  double area() const;               ///< sum over all facets [m^2]
  double area_before_phase() const;  ///< of facets that opened before the last dynamic phase [m^2]
};

/// The load time that is time zero of the facets [s]: the start of the last dynamic phase or, if that is NaN
/// (there was none), the last break.
double start_of_times(std::span<const fracture::Break> breaks, double phase_start);

/// The crack surface: for every break the dual facets of its most loaded cut (three for a cut 1|3, four for a
/// cut 2|2).
/// @param breaks in order of breaking
/// @param phase_start see start_of_times
/// @throws std::invalid_argument for a break outside the realization
CrackSurface make_crack_surface(const geometry::Body& body, const geometry::Realization& realization,
                                std::span<const fracture::Break> breaks, double phase_start);

/// Speed of Rayleigh waves in the tetrahedra that broke, each with its own stiffness and density [m/s]; 0 in
/// the others, unless all are equal.
/// @param material of the whole realization
mechanics::TetrahedronField<double> rayleigh_speeds(const CrackSurface& surface,
                                                    const geometry::Realization& realization,
                                                    const mechanics::MaterialField& material);

/// Mean slowness of Rayleigh waves in the tetrahedra of some facets, by area [s/m]; without facets that of
/// the body if it has one, NaN otherwise.
/// @param facets their numbers
/// @param rayleigh_speed see rayleigh_speeds
double mean_slowness(const CrackSurface& surface, std::span<const std::size_t> facets,
                     const mechanics::TetrahedronField<double>& rayleigh_speed);

}  // namespace crackle::cracks
