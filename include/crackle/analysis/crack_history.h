// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/crack_line.h"
#include "crackle/analysis/crack_surface.h"
#include "crackle/dynamics/sample_result.h"
#include "crackle/geometry/body.h"

#include <cstddef>
#include <vector>

namespace crackle::analysis {

/// The cracks at the moments of a sample's history; each table has rows x crack starts.
struct CrackHistory {
  std::size_t n_starts = 0;
  std::vector<double> area;          ///< of all open facets of the start's cracks [m^2]
  std::vector<double> length;        ///< arc length of the start's longest crack line up to its tip [m]
  std::vector<double> speed;         ///< of that tip [m/s]; NaN if it is not moving
  std::vector<double> release_rate;  ///< released energy per area of tip advance [J/m^2]; NaN likewise
};

/// Growth of the cracks of each crack start.
///
/// The tip reaches a point of the line when the crack has opened there or farther on, by the
/// through-thickness mean of the times; between points it moves linearly in time. Speed and energy release
/// rate are taken over a window around the tip, a tenth of the line (speed_window_share) but at least
/// speed_window_spacings, truncated at the line's ends. The speed is the inverse slope of a straight line
/// fitted to time over position; the rate is the energy released by tetrahedra of all the start's cracks
/// while the tip passed the window, divided by window times thickness. Both are given for the last dynamic
/// phase, while the tip is within the line.
/// @param lines crack_lines of the same surface
CrackHistory crack_history(const geometry::Body& body, const CrackSurface& surface,
                           const std::vector<CrackLine>& lines, const dynamics::SampleResult& result);

}  // namespace crackle::analysis
