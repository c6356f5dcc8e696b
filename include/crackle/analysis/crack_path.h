// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/branching.h"
#include "crackle/analysis/crack_surface.h"
#include "crackle/common/real.h"
#include "crackle/mechanics/tetrahedron_field.h"

#include <cstdint>
#include <vector>

namespace crackle::analysis {

/// Parameters of the crack surface analysis. A crack surface of broken tetrahedra is rough: one to three
/// tetrahedra thick, with small holes and stray breaks at its sides, so no closed sheet is required below.
/// Lengths in "spacings" are multiples of the local mesh spacing (local_spacing).

/// Opened facets farther apart than this across the crack belong to different crossings [spacings].
inline constexpr double crossing_gap = 0.6;
/// Facets of one crossing may be this far apart through the thickness [spacings].
inline constexpr double hole_size = 1.5;
/// A crossing that covers a smaller share of the thickness is a stray break and does not count.
inline constexpr double min_thickness_share = 0.3;
/// A branch whose crossing covers a smaller share of the thickness does not count.
inline constexpr double min_branch_share = 0.1;
/// A crack that crosses this share of its ligament is developed.
inline constexpr double developed_share = 0.4;
/// A developed crack that crosses this share of the ligament is a main crack.
inline constexpr double through_share = 0.6;
/// A crack that crosses less than this share of the ligament has not started.
inline constexpr double started_share = 0.1;
/// Window for the speed of a front along its way, as a share of the ligament; at least speed_window_spacings.
inline constexpr double speed_window_share = 0.1;
inline constexpr double speed_window_spacings = 4;
/// The fastest window minimizes its time plus this many standard errors.
inline constexpr double speed_standard_errors = 4;
/// Two paths overlap where they are no farther apart than this share of the body's width.
inline constexpr double overlap_distance_share = 0.1;
/// Two developed cracks are (anti-)symmetric if their paths overlap by at least this share.
inline constexpr double min_overlap = 0.3;

/// The crossing of a section by one branch.
struct BranchCrossing {
  double position;      ///< through-thickness mean [m]
  double share;         ///< covered share of the thickness
  std::int32_t branch;  ///< see CrackBranches
};

/// The crossing of one section by the cracks of one crack start. The position is the coordinate along the
/// section: z if y is constant, y if z is constant, the distance from the start of a line otherwise.
struct SectionCrossing {
  double position;  ///< through-thickness mean of the main crossing [m]; NaN if the crack did not arrive
  double spread;    ///< standard deviation of the position through the thickness [m]; NaN likewise
  /// Through-thickness mean of the time at which the crack first opened there, since the onset of the last
  /// dynamic phase [s]; NaN likewise. If part of it opened in that phase, earlier openings count as at the
  /// onset.
  double arrival;
  std::vector<BranchCrossing> branches;  ///< the separate crossings, sorted by position
};

/// Crossings for every crack start and section, row-major: [start * n_sections + section], in the order of
/// input::Sections::all.
///
/// The facets of the start's cracks intersect the plane of the section in segments (x, position). Segments
/// within crossing_gap in position and hole_size in x of each other form one crossing; crossings that cover
/// less than min_thickness_share of the thickness are ignored. Within a crossing, the parts of different
/// branches are separate crossings: for each branch the largest part if it covers min_branch_share, and
/// further ones that cover min_thickness_share. The main crossing is that of the main branch or, without one,
/// the crossing that covers most of the thickness (the earliest among equals). The position is its mean over
/// the covered thickness, averaging over segments at equal x, and the spread is its standard deviation over
/// that thickness. A section at less than 45 degrees to the ligament has no crossings, since the crack runs
/// along it: for example sections y and a crack from a notch in a z-face. Cracks from starts without a
/// ligament can cross any section. Crossings beyond the ends of a line do not count.
std::vector<SectionCrossing> section_crossings(const geometry::Body& body, const CrackSurface& surface,
                                               const CrackBranches& branches,
                                               const input::Sections& sections);

/// Share of its ligament that the crack from each start crosses, up to the farthest station where it covers
/// min_thickness_share of the thickness; in steps of 0.02. The largest value over the start's ligaments
/// (ligaments_through_holes).
std::vector<double> crossed_shares(const geometry::Body& body, const CrackSurface& surface);

/// The start of the leading crack: the one that crosses the largest share of its ligament (crossed_shares).
/// Among equals, the one where the first facet at the farthest station opened first; then the one with the
/// lowest number. -1 if no crack has started.
int leading_start(const geometry::Body& body, const CrackSurface& surface);

/// How the leading crack met with holes.
enum class HolePassage : std::int32_t { none = 0, ends = 1, passes = 2 };

/// The first hole that the leading crack ran into, see HoleEntry; not one that it touched in passing.
struct LeadersHole {
  std::int32_t hole = -1;  ///< number of the crack start; -1 for none
  /// `passes` if a crack of at least min_crack_length goes on from the hole, away from where the leader came.
  HolePassage passage = HolePassage::none;
};
LeadersHole leaders_hole(const geometry::Body& body, const CrackSurface& surface, int leading);

/// The crack pattern of a sample, as stored in /samples/pattern.
enum class Pattern : std::int32_t { none = 0, one_crack = 1, two_cracks = 2, other = 3 };

/// Anti-symmetry of the cracks of two starts: the overlap of one path with the other rotated by 180 degrees
/// about the midpoint between the tips.
///
/// Both paths are main crossings at 50 stations across the ligament. The overlap is the share of the stations
/// reached by either crack at which both are present and no farther apart than overlap_distance_share of the
/// width: 1 for congruent paths, 0 if only one crack runs. NaN for ligaments that are not opposite, for
/// starts without a ligament, and without any crack.
double path_overlap(const geometry::Body& body, const CrackSurface& surface, int one, int other);

/// The overlap of the two starts whose cracks run farthest (the first ones among equals); NaN for a body with
/// fewer than two.
double pattern_overlap(const geometry::Body& body, const CrackSurface& surface);

/// Pattern by how far cracks run along their ligaments (ligaments_through_holes): one_crack if exactly one is
/// developed and it is a main crack; two_cracks if exactly two are developed and their pattern_overlap is at
/// least min_overlap, or NaN because they are not those of straight starts; none if no crack has started;
/// other in all other cases, and if a crack that belongs to no start covers developed_share of the width.
Pattern classify(const geometry::Body& body, const CrackSurface& surface);

/// How fast the fastest crack front ran; NaN if none advances by a window in the last dynamic phase.
struct CrackSpeed {
  double largest = not_a_number;  ///< [m/s]
  /// Largest ratio of the speed over a window to the Rayleigh speed there, that of a wave in the tetrahedra
  /// that broke on it. It need not be where the speed is largest.
  double largest_ratio = not_a_number;
};

/// Largest speeds of the crack fronts along their own ways over a window.
///
/// A way is the crack's path in the plane of the plate, in any direction, curved or kinked; that of the main
/// branch (find_branches) along the straight line from the root to the crack's farthest end (crack_chords).
/// It is the longest chain of connected pieces (as in crack_lines) across that line, with a smoothed path,
/// and the tetrahedra of the chain have the arc length of the nearest point of the path. Side branches and
/// splinters do not count, nor do the chain's steps from one branch to another beside it, which are faster
/// than the Rayleigh speed. A window is a share of the ligament from which the crack
/// starts (speed_window_share), measured along the way.
///
/// The front of a start's crack is divided into columns through the thickness, two mean spacings wide. A
/// column advances when a tetrahedron opens ahead of all earlier ones, to the mean position of its facets; in
/// between it moves linearly in time. The course of the front is the mean time at which the columns pass a
/// position. Facets that open in the dynamic phase more than three spacings ahead of the front, such as those
/// of another crack on its way, and what opens next to these, count once the front reaches them, and no speed
/// is taken over such a jump.
///
/// The maximum of many noisy speeds is biased upwards, increasingly so for shorter windows. Therefore a
/// window's time is taken from a line or a parabola, fitted by least squares to a stretch of at least one
/// window (two for a parabola). A longer stretch is accepted as long as the polynomial fits within its
/// scatter: the next higher polynomial adds no more than two standard errors, and every window in the stretch
/// agrees within speed_standard_errors. Among all stretches, and windows at their ends, the one with the
/// smallest time plus speed_standard_errors is the fastest, and likewise in proportion to the time of a
/// Rayleigh wave; its speed, without the errors, is returned. Thus
/// a front at constant speed is measured over most of its way, and one with changing speed over a
/// window. Where two cracks meet, or the way passes between branches side by side, the speed is
/// overestimated: of 200 samples of the paper's model four have 0.95 to 1.23 times the Rayleigh speed, all
/// others at most 0.83.
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
/// @param rayleigh_speed see rayleigh_speeds
CrackSpeed max_crack_speed(const geometry::Body& body, const CrackSurface& surface,
                           const mechanics::TetrahedronField<double>& rayleigh_speed);

}  // namespace crackle::analysis
