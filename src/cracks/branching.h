// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cracks/crack_ligaments.h"
#include "cracks/crack_surface.h"
#include "geometry/body.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::cracks {

/// Parameters of the detection of branching, in local mesh spacings; jobs/results.md gives their accuracy.

/// Opened facets within this distance across the crack, as seen in a window, belong to one branch.
inline constexpr double branch_gap = 0.4;
/// Branches are separated by a gap over at least this length.
inline constexpr double min_gap_length = 2;
/// Minimum distance of a branch's end from where the gap begins. The branch itself is longer by 1 to 2
/// spacings, over which the thickness of the branches hides the gap.
inline constexpr double min_branch_length = 2.5;
/// Minimum of the largest gap width along that length.
inline constexpr double min_branch_distance = 0.75;
/// Branches that meet over at most this length and separate again are the same branches; branches that
/// separate over less than this and then stay united form a hole in the crack.
inline constexpr double reunion_length = 4;
/// Connected pieces of the crack with a smaller extent are stray breaks.
inline constexpr double stray_size = 2;
/// Thickness of the windows for detecting branching in space; each overlaps half of the next.
inline constexpr double window_thickness = 3;

/// A place where one crack splits into two branches; find_forks says what its members are in a solid.
struct BranchingPoint {
  std::int32_t start;   ///< number of the crack start
  std::int32_t parent;  ///< number of the branch that the secondary one leaves, see CrackBranches; not stored
  double x;             ///< centre of the through-thickness range of the secondary branch [m]
  double y, z;          ///< where the gap between the branches begins [m]
  double
      time;  ///< when half of the first min_branch_length of the later branch had opened, since the onset [s]
  double length;  ///< straight length of the secondary branch, from the branching point to its end [m]
  double angle;   ///< between the branches over their first min_branch_length [rad]
  double share;   ///< of the thickness, spanned by the secondary branch
  bool is_in_projection;  ///< detected in the projection of the crack on the plane of the plate
  bool is_in_space;       ///< detected in a window through the thickness
};

/// A crack surface decomposed into branches.
struct CrackBranches {
  std::vector<BranchingPoint> points;  ///< by crack start, and along the crack
  std::vector<std::int32_t>
      branch;  ///< of each facet: 0 for a crack's main branch, i + 1 for the secondary branch of points[i]
  std::int32_t n_projected() const {
    return static_cast<std::int32_t>(std::ranges::count_if(points, &BranchingPoint::is_in_projection));
  }
  /// @param least length of the secondary branch [m]
  std::int32_t n_in_space(double least = 0) const {
    return static_cast<std::int32_t>(std::ranges::count_if(
        points, [&](const BranchingPoint& point) { return point.is_in_space && point.length >= least; }));
  }
};

/// Finds the branching points of the cracks on all ligaments of the starts (crack_ligaments).
///
/// This is the only detection of branching: lines (crack_lines) and crossings (section_crossings) follow its
/// decomposition of the surface.
///
/// A crack is analysed in windows through the thickness (for branching in space) and as a whole (for
/// branching in the projection). In each window the facets are projected on the plane of the plate and cut at
/// stations a quarter of a spacing apart along the crack advance; facets within branch_gap of each other form
/// a run. A run with several continuations is a branching point if at least two of them are min_gap_length
/// long, have no run in common over that length, and are min_branch_distance apart somewhere on it.
/// Continuations that meet and separate again within reunion_length are the same branches. Branching points
/// of different windows, and of the projection, are identified if each of their branches has facets in
/// common. The main branch is the one that extends farthest along the ligament or, if both end within
/// min_branch_length of each other, the one with the larger area; the other is the secondary branch.
CrackBranches find_branches(const geometry::Body& body, const CrackSurface& surface);

/// The same for the cracks on these ligaments.
CrackBranches find_branches(const geometry::Body& body, const CrackSurface& surface,
                            std::span<const CrackLigament> ligaments);

}  // namespace crackle::cracks
