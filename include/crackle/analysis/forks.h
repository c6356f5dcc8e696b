// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/crack_surface.h"
#include "crackle/geometry/body.h"

#include <cstdint>
#include <vector>

namespace crackle::analysis {

/// Parameters of fork detection, in local mesh spacings; jobs/results.md gives their accuracy.

/// Opened facets within this distance across the crack, as seen in a window, belong to one arm.
inline constexpr double arm_gap = 0.4;
/// The arms of a fork are separated by a gap over at least this length.
inline constexpr double min_gap_length = 2;
/// Minimum distance of an arm's end from where the gap begins. The arm itself is longer by 1 to 2 spacings,
/// over which the thickness of the arms hides the gap.
inline constexpr double min_arm_length = 2.5;
/// Minimum of the largest gap width along that length.
inline constexpr double min_arm_distance = 0.75;
/// Arms that meet over at most this length and separate again are the same arms; arms that separate over less
/// than this and then stay together form a hole in the crack.
inline constexpr double reunion_length = 4;
/// Connected pieces of the crack with a smaller extent are stray breaks.
inline constexpr double stray_size = 2;
/// Thickness of the windows for detecting forks in space; each overlaps half of the next.
inline constexpr double window_thickness = 3;

/// A place where one crack splits into two.
struct Fork {
  std::int32_t notch;  ///< number of the crack start
  double x;            ///< centre of the through-thickness range of the secondary arm [m]
  double y, z;         ///< where the gap between the arms begins [m]
  double time;    ///< when half of the first min_arm_length of the later arm had opened, since the onset [s]
  double length;  ///< straight length of the secondary arm, from the fork to its end [m]
  double angle;   ///< between the arms over their first min_arm_length [rad]
  double share;   ///< of the thickness, spanned by the secondary arm
  bool is_in_projection;  ///< detected in the projection of the crack on the plane of the plate
  bool is_in_space;       ///< detected in a window through the thickness
};

/// A crack surface decomposed into arms.
struct CrackArms {
  std::vector<Fork> forks;  ///< by crack start, and along the crack
  std::vector<std::int32_t>
      arm;  ///< of each facet: 0 for a crack's main arm, i + 1 for the secondary arm of forks[i]
  std::int32_t n_projected() const {
    return static_cast<std::int32_t>(std::ranges::count_if(forks, &Fork::is_in_projection));
  }
  std::int32_t n_in_space() const {
    return static_cast<std::int32_t>(std::ranges::count_if(forks, &Fork::is_in_space));
  }
};

/// Finds the forks of the cracks on all ways of the starts (crack_ways).
///
/// A crack is analysed in windows through the thickness (for forks in space) and as a whole (for forks in the
/// projection). In each window the facets are projected on the plane of the plate and cut at stations a
/// quarter of a spacing apart along the crack advance; facets within arm_gap of each other form a run. A run
/// with several continuations is a fork if at least two of them are min_gap_length long, have no run in
/// common over that length, and are min_arm_distance apart somewhere on it. Continuations that meet and
/// separate again within reunion_length are the same arms. Forks of different windows, and of the projection,
/// are identified if each of their arms has facets in common. The main arm is the one that extends farthest
/// along the ligament or, if both end within min_arm_length of each other, the one with the larger area; the
/// other is the secondary arm.
CrackArms find_forks(const geometry::Body& body, const CrackSurface& surface);

}  // namespace crackle::analysis
