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
  std::vector<double> area;          ///< of all facets that are open, of the start's cracks [m^2]
  std::vector<double> length;        ///< of the start's longest crack line, along it, up to the tip [m]
  std::vector<double> speed;         ///< of that tip [m/s]; NaN where none runs
  std::vector<double> release_rate;  ///< energy over the area that the tip advances by [J/m^2]; NaN likewise
};

/// How the cracks of each crack start grew.
///
/// The tip has reached a point of the line when the crack has opened there or farther on, by the
/// through-thickness mean of the times; between points it is linear in time. Its speed and the energy release
/// rate are those over a window round it, a tenth of the line (speed_window_share) but at least
/// speed_window_spacings, less at the line's ends: the speed is the inverse slope of a straight line fitted
/// to time over place, the rate what tetrahedra of all the start's cracks released while the tip passed the
/// window, over window times thickness. Both are for the last dynamic phase, while the tip is in the line.
/// @param lines crack_lines of the same surface
CrackHistory crack_history(const geometry::Body& body, const CrackSurface& surface,
                           const std::vector<CrackLine>& lines, const dynamics::SampleResult& result);

}  // namespace crackle::analysis
