// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cracks/section_crossings.h"
#include "geometry/body.h"

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace crackle::cracks {

/// The projection of an open facet along the crack advance: a segment through the thickness (x) and across.
struct Trace {
  double x[2];       ///< ends, x[0] <= x[1] [m]
  double across[2];  ///< at these ends [m]
  double spacing;    ///< local mesh spacing [m]
  double time;       ///< [s]
  std::size_t facet;
};

/// The facets of cracks that belong to this crack start, in order of breaking; -1 for cracks that started
/// elsewhere.
std::vector<std::size_t> facets_from(const CrackSurface& surface, std::int32_t start);

/// Those of cracks that touched this start first (Crack::origin).
std::vector<std::size_t> facets_begun_at(const CrackSurface& surface, std::int32_t start);

/// Mean local spacing of facets [m]; 0 without facets.
double mean_spacing(const CrackSurface& surface, std::span<const std::size_t> facets);

/// Segments in which facets intersect the plane, by its coordinate across; also beyond the plane's ends.
std::vector<Trace> intersect(const CrackSurface& surface, std::span<const std::size_t> facets,
                             const geometry::CrossPlane& plane);

/// A facet's extent through the thickness and across, where the latter coordinate is dot(p, across).
Trace extent(const CrackSurface& surface, std::size_t facet, const Vector& across);

/// Separate groups of traces (see section_crossings), excluding those that cover less than
/// min_thickness_share of the thickness; each ascending, groups ordered by their first member.
std::vector<std::vector<std::size_t>> group(std::span<const Trace> traces, double thickness);

/// Smallest and largest advance of a facet's corners [m].
std::pair<double, double> advances(const CrackFacet& facet, const geometry::CrackStart& start);

/// Indices in ascending order, each once.
using Indices = std::vector<std::size_t>;

void sort_unique(Indices& numbers);
bool intersects(const Indices& a, const Indices& b);
void add(Indices& to, const Indices& from);

/// The crossing of a plane by a crack, projected through the thickness.
struct Crossing {
  double mean;    ///< over the covered x, of the mean of the traces at equal x [m]
  double spread;  ///< standard deviation of that mean over the covered x [m]
  double time;    ///< at which the first facet of its group opened [s]
  /// Mean over the covered x of the first opening time; if part of it opened in the last dynamic phase,
  /// earlier openings count as at its start [s].
  double arrival;
  std::vector<BranchCrossing> branches;  ///< all separate crossings, ascending
};

/// The main crossing (see section_crossings); empty if no group counts.
/// @param branch of each facet; if empty, all belong to the main branch
/// @param plane crossings beyond its ends do not count
std::optional<Crossing> main_crossing(std::span<const Trace> traces, double thickness,
                                      std::span<const std::int32_t> branch = {},
                                      const geometry::CrossPlane* plane = nullptr);

/// The facets of a crack in one slab.
struct ChainLink {
  std::size_t slab;
  Indices facets;
};

/// The longest chain of connected pieces of a crack, cut perpendicular to a line into slabs that start at its
/// tip; among equals the one nearest to the tip. In a slab, facets form pieces as in section_crossings;
/// pieces of neighbouring slabs are connected if they share a facet.
/// @param spacing thickness of a slab [m]
/// @param thickness of the body [m]
/// @param from_first start in the first slab that has pieces
std::vector<ChainLink> longest_chain(const CrackSurface& surface, std::span<const std::size_t> facets,
                                     const geometry::CrackStart& line, double spacing, double thickness,
                                     bool from_first);

}  // namespace crackle::cracks
