// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cracks/branching.h"
#include "cracks/crack_surface.h"

#include <cstdint>
#include <vector>

namespace crackle::cracks {

/// A path's direction is measured over this share of the ligament along the path, but at least over
/// kink_window_spacings mean local spacings: 1.5 mm in a plate 24.5 mm wide with notches 5.5 mm deep, for
/// spacings up to 0.5 mm. Hence a kink depends on the body's size and not on its mesh.
inline constexpr double kink_window_share = 0.08;
inline constexpr double kink_window_spacings = 3;
/// A path has a kink where its direction changes by this angle between the windows before and after a point
/// [rad]. An arc of radius R deflects by window / R from one window to the next: radii of 0.18 ligaments (3.4
/// mm in that plate) and more count as smooth. Kinks within one window of each other are one.
inline constexpr double kink_angle = 0.4537856055185257;  // 26 degrees

/// A point of a crack's line in the plane of the plate.
struct LinePoint {
  double y;       ///< [m]
  double z;       ///< [m]
  double spread;  ///< standard deviation through the thickness, across the ligament [m]
  double time;  ///< when the crack arrived here, through-thickness mean, since the onset of the last dynamic
                ///< phase [s]
};

/// One branch of a crack as a line for plotting: the through-thickness mean of its pieces, one point per mean
/// local spacing of advance.
struct CrackLine {
  std::int32_t start;   ///< number of the crack start
  std::int32_t parent;  ///< index of the line that this branch leaves; -1 for the main line of a ligament
  std::vector<LinePoint> points;  ///< a branch's first point is on its parent
  std::int32_t kinks;             ///< local maxima of the deflection within a window, of at least kink_angle
  double bend;  ///< direction of the last window minus that of the first [rad]; 0 for lines shorter than two
                ///< windows
};

/// The lines of the branches on all ligaments of the crack starts (crack_ligaments), each main line before
/// the branches that leave it.
///
/// The facets of each branch are cut perpendicular to the crack advance into slabs as thick as the mean local
/// spacing. In each slab they form pieces as in section_crossings, so stray breaks do not count; pieces of
/// neighbouring slabs are connected if they share a facet. A line is the longest chain of connected pieces;
/// the main line's starts in the slab nearest to the tip. A branch that covers too little of the thickness to
/// form pieces has no line.
/// @param branches find_branches of the same surface
std::vector<CrackLine> crack_lines(const geometry::Body& body, const CrackSurface& surface,
                                   const CrackBranches& branches);

/// Number of kinks in all lines.
std::int32_t count_kinks(const std::vector<CrackLine>& lines);

}  // namespace crackle::cracks
