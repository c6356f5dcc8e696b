// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/crack_surface.h"
#include "crackle/geometry/body.h"

#include <cstdint>
#include <vector>

namespace crackle::analysis {

/// The parameters by which forks are found, in local mesh spacings; jobs/results.md says how well they do.

/// Opened facets this close to each other across the crack, seen in a window, are one arm.
inline constexpr double arm_gap = 0.4;
/// Both arms of a fork have a gap between them over this length.
inline constexpr double min_gap_length = 2;
/// Each arm ends at least this far from where the gap begins: from where the crack parts it is 1 to 2
/// spacings longer, on which the arms' own thickness hides the gap.
inline constexpr double min_arm_length = 2.5;
/// Somewhere on that length the gap between the arms is this wide.
inline constexpr double min_arm_distance = 0.75;
/// Arms that meet for no longer than this and part again are the same arms; arms that are apart for less than
/// this and stay together from there on are a hole in the crack.
inline constexpr double reunion_length = 4;
/// Connected pieces of the crack that extend over less are stray breaks.
inline constexpr double stray_size = 2;
/// Thickness of the windows in which forks in space are looked for; each overlaps half of the next.
inline constexpr double window_thickness = 3;

/// A place where one crack becomes two that go on apart.
struct Fork {
  std::int32_t notch;  ///< number of the crack start
  double x;            ///< middle of the range that the arm which leaves spans through the thickness [m]
  double y, z;         ///< where the gap between the arms begins [m]
  double time;    ///< when half of the first min_arm_length of the later arm had opened, since the onset [s]
  double length;  ///< of the arm that leaves, from the fork straight to its end [m]
  double angle;   ///< between the arms over their first min_arm_length [rad]
  double share;   ///< of the thickness: the range that the arm which leaves spans
  bool is_in_projection;  ///< seen on the crack projected on the plane of the plate
  bool is_in_space;       ///< seen in a window through the thickness
};

/// A crack surface told apart into arms.
struct CrackArms {
  std::vector<Fork> forks;  ///< by crack start, and in the order in which a crack comes to them
  std::vector<std::int32_t>
      arm;  ///< of each facet: 0 for a crack's main arm, i + 1 for the one that leaves it at forks[i]
  std::int32_t n_projected() const {
    return static_cast<std::int32_t>(std::ranges::count_if(forks, &Fork::is_in_projection));
  }
  std::int32_t n_in_space() const {
    return static_cast<std::int32_t>(std::ranges::count_if(forks, &Fork::is_in_space));
  }
};

/// Finds the forks of the cracks on all ways of the starts (crack_ways).
///
/// A crack is looked at in windows through the thickness (for forks in space) and as a whole (for those of
/// its projection). In each the facets are projected on the plane of the plate, and cut at stations a quarter
/// of a spacing apart along the advance of the crack; facets within arm_gap of each other form a run. A run
/// that goes on in several ways is a fork when at least two of them are min_gap_length long, have no run in
/// common on that length, and are min_arm_distance apart somewhere on it. Ways that meet and part once more
/// within reunion_length are the same arms. Forks of different windows, and of the projection, are one when
/// each of their arms has facets in common. Of the arms the main one is the one that comes farthest along the
/// ligament, of two that end within min_arm_length of each other the one with the larger area; the
/// other one leaves.
CrackArms find_forks(const geometry::Body& body, const CrackSurface& surface);

}  // namespace crackle::analysis
