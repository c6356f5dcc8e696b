// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/crack_surface.h"

#include <cstdint>
#include <vector>

namespace crackle::analysis {

/// A path's direction is measured over this share of the ligament along the path, but at least over
/// kink_window_spacings mean local spacings: 1.5 mm in a plate 24.5 mm wide with notches 5.5 mm deep, for
/// spacings up to 0.5 mm. Hence a kink depends on the body's size and not on its mesh.
inline constexpr double kink_window_share = 0.08;
inline constexpr double kink_window_spacings = 3;
/// A path has a kink where its direction changes by this angle between the windows before and after a point
/// [rad]. An arc of radius R turns by window / R from one window to the next: radii of 0.18 ligaments (3.4 mm
/// in that plate) and more count as smooth. Kinks within one window of each other are one.
inline constexpr double kink_angle = 0.4537856055185257;  // 26 degrees

/// A point of a crack's line in the plane of the plate.
struct LinePoint {
  double y;       ///< [m]
  double z;       ///< [m]
  double spread;  ///< standard deviation through the thickness, across the ligament [m]
  double time;  ///< when the crack arrived here, through-thickness mean, since the onset of the last dynamic
                ///< phase [s]
};

/// A crack on its way as a line for plotting: the through-thickness mean of its pieces, starting at the notch
/// tip, one point per mean local spacing of advance.
struct CrackLine {
  std::int32_t notch;   ///< number of the crack start
  std::int32_t parent;  ///< index of the line from which this branch departs; -1 for the main line of a way
  std::vector<LinePoint> points;  ///< a branch's first point is on its parent
  std::int32_t kinks;             ///< local maxima of the turn within a window, of at least kink_angle
  double bend;  ///< direction of the last window minus that of the first [rad]; 0 for lines shorter than two
                ///< windows
};

/// The lines of all ways of the crack starts (crack_ways), each main line before its branches.
///
/// The body is cut perpendicular to the crack advance into slabs as thick as the mean local spacing. In each
/// slab the facets form pieces as in section_crossings, so stray breaks do not count; pieces of neighbouring
/// slabs are connected if they share a facet. Ways from a piece are separate if each is at least
/// min_branch_length long and they have no piece in common over that length. The main line starts in the
/// piece nearest to the tip from which the longest way continues, and follows the longest way at every
/// branching point (the first one of equal length). All other separate ways are branches, which end where
/// they meet an existing line.
std::vector<CrackLine> crack_lines(const geometry::Body& body, const CrackSurface& surface);

/// Number of kinks in all lines.
std::int32_t count_kinks(const std::vector<CrackLine>& lines);

}  // namespace crackle::analysis
