// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "cracks/front_trajectory.h"

#include <span>

namespace crackle::cracks {

/// How fast the fastest crack front ran; NaN if none advances by a window in the last dynamic phase.
struct CrackSpeed {
  double largest = not_a_number;  ///< [m/s]
  /// Largest ratio of the speed over a window to the Rayleigh speed there, that of a wave in the tetrahedra
  /// that broke on it. It need not be where the speed is largest.
  double largest_ratio = not_a_number;
};

/// Largest speeds of the crack fronts along their own paths over a window.
///
/// The path of each front is its FrontTrajectory: side branches and splinters do not count, nor do steps from
/// one branch to another beside it, which are faster than the Rayleigh speed. A window is a share of the
/// ligament from which the crack starts (speed_window_share), measured along the path.
///
/// The front of a start's crack is divided into columns through the thickness, two mean spacings wide. A
/// column advances when a tetrahedron opens ahead of all earlier ones, to the mean position of its facets; in
/// between it moves linearly in time. The course of the front is the mean time at which the columns pass a
/// position. Facets that open in the dynamic phase more than front_reach ahead of the front, such as those
/// of another crack ahead of it, and what opens next to these, count once the front reaches them, and no
/// speed is taken over such a jump.
///
/// The maximum of many noisy speeds is biased upwards, increasingly so for shorter windows. Therefore a
/// window's time is taken from a line or a parabola, fitted by least squares to a stretch of at least one
/// window (two for a parabola). A longer stretch is accepted as long as the polynomial fits within its
/// scatter: the next higher polynomial adds no more than two standard errors, and every window in the stretch
/// agrees within speed_standard_errors. Among all stretches, and windows at their ends, the one with the
/// smallest time plus speed_standard_errors is the fastest, and likewise in proportion to the time of a
/// Rayleigh wave; its speed, without the errors, is returned. Thus
/// a front at constant speed is measured over most of its path, and one with changing speed over a
/// window. Where two cracks meet, or the path passes between branches side by side, the front seems to jump:
/// nothing counts that overlaps a jump of the FrontTrajectory, or a window passed faster than a Rayleigh
/// wave, nor a window that the columns pass much faster (columns_lead) than the points of the
/// FrontTrajectory: these are means through the thickness, which what opens beside the path does not hurry.
///
/// Error of the measured speed for synthetic fronts, in meshes of 0.2 to 0.6 mm and a ligament of 19 mm, 24
/// each: bias and standard deviation [%], range over the meshes. The scatter is that of each tetrahedron's
/// position when it breaks.
///
/// | scatter [spacings] | constant, 1 mm thick | constant, 2 to 5 mm | from 200 to 600 m/s, 1 to 5 mm |
/// |---|---|---|---|
/// | 0 | 0.0, 0.0 | 0.0, 0.0 | -0.4 to 0.1, 0.0 to 0.4 |
/// | 0.15 | 0.0 to 0.1, 0.0 to 0.2 | 0.0 to 0.1, 0.0 to 0.1 | -0.4 to 1.2, 0.2 to 1.3 |
/// | 0.3 | 0.1 to 1.5, 0.1 to 5.6 | 0.0 to 0.2, 0.1 to 0.4 | -0.4 to 2.7, 0.5 to 4.3 |
///
/// The largest errors are at a spacing of 0.6 mm in a thickness of 1 mm, where the front is a single column.
/// @param trajectories front_trajectories of its cracks
CrackSpeed max_crack_speed(const geometry::Body& body, std::span<const FrontTrajectory> trajectories);

}  // namespace crackle::cracks
