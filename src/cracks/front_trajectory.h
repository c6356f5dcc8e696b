// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cracks/crack_surface.h"
#include "geometry/body.h"
#include "mechanics/tetrahedron_field.h"

#include <array>
#include <cstdint>
#include <vector>

namespace crackle::cracks {

/// The path of a crack is smoothed over this many spacings to both sides.
inline constexpr double path_smoothing = 3;
/// What opens farther ahead of a front does not belong to it until the front has come there [spacings].
inline constexpr double front_reach = 2;
/// Window for the speed of a front along its path, as a share of the ligament; at least
/// speed_window_spacings.
inline constexpr double speed_window_share = 0.1;
inline constexpr double speed_window_spacings = 4;
/// The fastest window minimizes its time plus this many standard errors.
inline constexpr double speed_standard_errors = 4;

/// The position of a crack's front over time along the crack's own path, in any direction, curved or kinked.
/// Places are arc lengths from the crack's root in the plane of the plate.
struct FrontTrajectory {
  struct Point {
    double place;     ///< [m]
    double time;      ///< through-thickness mean of when the crack opened there [s]
    double reached;   ///< when its front had come there or farther on [s]
    int run;          ///< of the front between two of its jumps; -1: part of a jump
    double slowness;  ///< of Rayleigh waves in what broke there, mean over its area [s/m]
    double delay;     ///< of a Rayleigh wave from the first point, beyond one at the slowness there [s]
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

  double length() const { return points.empty() ? 0 : points.back().place; }
  /// Mean slowness of Rayleigh waves over a part of the path, in the material that broke there [s/m].
  double slowness(double from, double to) const;
  /// Time over a part of the path by a line fitted to those of its points [s]; 0 where these are too few.
  double mean_time(double from, double to) const;
};

/// The front trajectories of all cracks of the starts, one for each chord (Followed::chords).
///
/// The path is that of the longest path through connected pieces in slabs across the chord (CrackGraph), of
/// the main branch along the chord (find_branches). The through-thickness means of the pieces are smoothed
/// over path_smoothing spacings to both sides, since their scatter would make the path longer than the crack
/// is. A tetrahedron of the chain has the place of the nearest point of the path.
///
/// Where branches grow side by side, the chain can pass from one to the other. Of such a step to the side, by
/// more than two spacings and faster than a crack runs, only what it could run meanwhile is part of the path.
///
/// A front passes at most front_reach of what has not opened yet. It jumps where it meets what opened while
/// it was farther away, such as another crack, and where it passes a window faster than a Rayleigh wave; the
/// path is known there, but no speed.
/// @param rayleigh_speed see rayleigh_speeds; no crack exceeds it; infinity: all of the chain counts
std::vector<FrontTrajectory> front_trajectories(const geometry::Body& body, const CrackSurface& surface,
                                                const mechanics::TetrahedronField<double>& rayleigh_speed);

}  // namespace crackle::cracks
