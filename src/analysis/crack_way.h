// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/crack_surface.h"
#include "crackle/geometry/body.h"

#include <array>
#include <cstdint>
#include <vector>

namespace crackle::analysis {

/// The path of a way is smoothed over this many spacings to both sides.
inline constexpr double way_smoothing = 3;

/// A crack that runs in any direction, curved or kinked, as a course along its own path. Its places are arc
/// lengths from the root in the plane of the plate.
struct CrackWay {
  struct Point {
    double place;    ///< [m]
    double time;     ///< through-thickness mean of when the crack opened there [s]
    double reached;  ///< when it had opened there or farther on [s]
  };
  /// An opened tetrahedron.
  struct Opened {
    double time;              ///< [s]
    double place;             ///< of the mean of its facets [m]
    std::array<double, 2> x;  ///< extent through the thickness [m]
  };

  std::int32_t start;          ///< number of the crack start that the crack touched first (Crack::origin)
  double spacing;              ///< mean, local [m]
  double window;               ///< over which speeds are taken: speed_window_share, speed_window_spacings [m]
  std::vector<Point> points;   ///< along the path, about a spacing apart; at least two
  std::vector<Opened> opened;  ///< by time, then by place

  double length() const { return points.back().place; }
};

/// The ways of all cracks of the starts, one for each chord (crack_chords).
///
/// The path is that of the longest chain of connected pieces in slabs across the chord (longest_chain), of
/// the main branch along the chord (find_branches). The through-thickness means of the pieces are smoothed
/// over way_smoothing spacings to both sides, since their scatter would make the path longer than the crack
/// is. A tetrahedron of the chain has the place of the nearest point of the path.
///
/// Where branches grow side by side, the chain can pass from one to the other. Of such a step to the side, by
/// more than two spacings and faster than a crack runs, only what it could run meanwhile is part of the way.
/// @param rayleigh_speed that no crack exceeds; infinity: all of the chain counts [m/s]
std::vector<CrackWay> crack_ways(const geometry::Body& body, const CrackSurface& surface,
                                 double rayleigh_speed);

}  // namespace crackle::analysis
