// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "cracks/front_trajectory.h"
#include "dynamics/sample_result.h"
#include "geometry/body.h"

#include <cstddef>
#include <span>
#include <vector>

namespace crackle::cracks {

/// Every crack of a body that is not a plate at these moments; each table has rows x CrackSurface::cracks.
struct CracksInSpace {
  std::vector<double> area;   ///< of its open facets [m^2]
  std::vector<double> reach;  ///< greatest distance of these from the facet that opened first [m]
  std::vector<double> speed;  ///< at which the reach grows [m/s]; NaN where it does not
};

/// The speed is the inverse slope of a straight line fitted to time over reach, in the last dynamic phase and
/// over speed_window_spacings to both sides. Where cracks meet the reach jumps, and no speed above that of a
/// Rayleigh wave is given.
/// @param n_open facets of the surface at each moment
/// @param time of each moment, on the time axis of the facets [s]
CracksInSpace cracks_in_space(const CrackSurface& surface, std::span<const std::size_t> n_open,
                              std::span<const double> time, double rayleigh_speed);

/// The cracks at the moments of a sample's history; each table has rows x crack starts.
struct CrackHistory {
  std::size_t n_starts = 0;
  std::vector<double> area;    ///< of all open facets of the start's cracks [m^2]
  std::vector<double> length;  ///< from the crack start to the tip, along the path of the longest crack [m]
  std::vector<double> speed;   ///< of that tip [m/s]; NaN if it is not moving
  std::vector<double> speed_ratio;       ///< of this speed to the Rayleigh speed there; NaN likewise
  std::vector<double> release_rate;      ///< released energy per area of tip advance [J/m^2]; NaN likewise
  double rayleigh_speed = not_a_number;  ///< where all cracks ran, by mean_slowness [m/s]
  CracksInSpace in_space;                ///< empty for a plate
};

/// Growth of the cracks of each crack start.
///
/// A crack is followed along its own path, whatever its direction (FrontTrajectory). Its tip reaches a
/// point when the crack has opened there or farther on, by the through-thickness mean of the times; between
/// points, about a spacing apart, it moves linearly in time. Speed and energy release rate are taken over a
/// window around the tip, a tenth of the ligament (speed_window_share) but at least speed_window_spacings,
/// truncated at the ends of the path. The speed is the inverse slope of a straight line fitted to time over
/// place; the rate is the slope of one fitted to the energy that the tetrahedra of all the start's cracks had
/// released when the tip came there, divided by the thickness. Both are given for the last dynamic phase,
/// while the tip is moving. Where it meets what opened earlier (see max_crack_speed) it jumps, and
/// neither is given. Behind a hole (Crack::hole) a crack goes on along another path: the lengths of its paths
/// add up, and of two moving tips the faster one counts.
///
/// In other bodies than plates there are no paths: their length, speeds and rates are NaN.
/// @param trajectories front_trajectories of the same surface
/// @param rayleigh_speed see rayleigh_speeds
CrackHistory crack_history(const geometry::Body& body, const CrackSurface& surface,
                           const dynamics::SampleResult& result,
                           std::span<const FrontTrajectory> trajectories,
                           const mechanics::TetrahedronField<double>& rayleigh_speed);

}  // namespace crackle::cracks
