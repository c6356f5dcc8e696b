// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cracks/branching.h"
#include "cracks/crack_surface.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::cracks {

/// Parameters of the crossings of a crack surface. A crack surface of broken tetrahedra is rough: one to
/// three tetrahedra thick, with small holes and stray breaks at its sides, so no closed sheet is required
/// below. Lengths in "spacings" are multiples of the local mesh spacing (local_spacing).

/// Opened facets farther apart than this across the crack belong to different crossings [spacings].
inline constexpr double crossing_gap = 0.6;
/// Facets of one crossing may be this far apart through the thickness [spacings].
inline constexpr double hole_size = 1.5;
/// A crossing that covers a smaller share of the thickness is a stray break and does not count.
inline constexpr double min_thickness_share = 0.3;
/// A branch whose crossing covers a smaller share of the thickness does not count.
inline constexpr double min_branch_share = 0.1;
/// The crossing of a section by one branch.
struct BranchCrossing {
  double position;      ///< through-thickness mean [m]
  double share;         ///< covered share of the thickness
  std::int32_t branch;  ///< see CrackBranches
};

/// The crossing of one section by the cracks of one crack start. The position is the coordinate along the
/// section: z if y is constant, y if z is constant, the distance from the start of a line otherwise.
struct SectionCrossing {
  double position;  ///< through-thickness mean of the main crossing [m]; NaN if the crack did not arrive
  double spread;    ///< standard deviation of the position through the thickness [m]; NaN likewise
  /// Through-thickness mean of the time at which the crack first opened there, since the onset of the last
  /// dynamic phase [s]; NaN likewise. If part of it opened in that phase, earlier openings count as at the
  /// onset.
  double arrival;
  std::vector<BranchCrossing> branches;  ///< the separate crossings, sorted by position
};

/// The planes of an input's sections, in the order of input::Sections::all.
std::vector<geometry::CrossPlane> planes_of(const input::Sections& sections);

/// Crossings for every crack start and section, row-major: [start * n_sections + section].
///
/// The facets of the start's cracks intersect the plane of the section in segments (x, position). Segments
/// within crossing_gap in position and hole_size in x of each other form one crossing; crossings that cover
/// less than min_thickness_share of the thickness are ignored. Within a crossing, the parts of different
/// branches are separate crossings: for each branch the largest part if it covers min_branch_share, and
/// further ones that cover min_thickness_share. The main crossing is that of the main branch or, without one,
/// the crossing that covers most of the thickness (the earliest among equals). The position is its mean over
/// the covered thickness, averaging over segments at equal x, and the spread is its standard deviation over
/// that thickness. A section at less than 45 degrees to the ligament has no crossings, since the crack runs
/// along it: for example sections y and a crack from a notch in a z-face. Cracks from starts without a
/// ligament can cross any section. Crossings beyond the ends of a line do not count.
std::vector<SectionCrossing> section_crossings(const geometry::Body& body, const CrackSurface& surface,
                                               const CrackBranches& branches,
                                               std::span<const geometry::CrossPlane> sections);

}  // namespace crackle::cracks
