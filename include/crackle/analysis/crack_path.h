// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/crack_surface.h"
#include "crackle/analysis/forks.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace crackle::analysis {

/// The measures by which crack surfaces are read. A crack surface of broken tetrahedra is rough: one to three
/// tetrahedra thick, with small holes and stray breaks at its sides, so nothing below asks for a closed
/// sheet. Lengths in "spacings" are multiples of the local mesh spacing (local_spacing).

/// Opened facets that are further apart than this across the crack lie on different branches [spacings].
inline constexpr double branch_gap = 0.6;
/// Facets of one branch may be this far apart through the thickness [spacings].
inline constexpr double hole_size = 1.5;
/// A crossing that covers a smaller share of the thickness is a stray break and does not count.
inline constexpr double min_thickness_share = 0.3;
/// An arm whose crossing covers a smaller share of the thickness does not count.
inline constexpr double min_arm_share = 0.1;
/// A crack that crosses this share of its ligament is developed.
inline constexpr double developed_share = 0.4;
/// A developed crack that crosses this share of the ligament is a main crack.
inline constexpr double through_share = 0.6;
/// A crack that crosses less than this share of the ligament has not started.
inline constexpr double started_share = 0.1;
/// Branches shorter than this, or apart from each other on a shorter way, do not count [spacings].
inline constexpr int min_branch_length = 3;
/// A front's speed is taken over this share of the ligament, but at least over speed_window_spacings.
inline constexpr double speed_window_share = 0.1;
inline constexpr double speed_window_spacings = 4;
/// The fastest window is the one whose time plus this many standard errors is least.
inline constexpr double speed_standard_errors = 4;
/// Two paths lie over each other where they are no further apart than this share of the body's width.
inline constexpr double overlap_distance_share = 0.1;
/// Two developed cracks are (anti-)symmetric when their paths overlap by at least this share.
inline constexpr double min_overlap = 0.3;

/// Where one arm crosses a section.
struct ArmCrossing {
  double position;   ///< through-thickness mean [m]
  double share;      ///< of the thickness that it covers
  std::int32_t arm;  ///< see CrackArms
};

/// Where the cracks of one crack start cross one section. The position is the coordinate along the section: z
/// where y is const, y where z is const, the distance from its start on a line.
struct SectionCrossing {
  double position;  ///< through-thickness mean of the main crossing [m]; NaN where the crack did not arrive
  double spread;    ///< standard deviation of the position through the thickness [m]; NaN likewise
  /// Through-thickness mean of when the crack opened there first, since the onset of the last dynamic phase
  /// [s]; NaN likewise. Where it opened in that phase, what was open before counts as from the onset.
  double arrival;
  std::vector<ArmCrossing> arms;  ///< the separate crossings, in ascending order of their positions
};

/// Crossings for every crack start and section, row-major: [start * n_sections + section], in the order of
/// input::Sections::all.
///
/// The facets of the start's cracks meet the plane of the section in segments (x, position). Segments within
/// branch_gap in position and hole_size in x of each other form one crossing; crossings that cover less than
/// min_thickness_share of the thickness are left out. What different arms have in one of them are separate
/// crossings: of each arm the largest when it covers min_arm_share, others that cover min_thickness_share.
/// The main crossing is that of the main arm, or where it has none the one that covers most of the thickness
/// (of equals the earliest); the position is its mean over the thickness covered, where several segments lie
/// over each other their mean, and the spread its standard deviation over that thickness. A section that
/// makes less than 45 degrees with the ligament has no crossings: the crack runs along it, as one from a
/// notch in a z-face along sections y. Cracks from starts without a
/// ligament can cross any section. Crossings beyond the ends of a line do not count.
std::vector<SectionCrossing> section_crossings(const geometry::Body& body, const CrackSurface& surface,
                                               const CrackArms& arms, const input::Sections& sections);

/// Share of its ligament that the crack from each start crosses, up to the farthest place where it covers
/// min_thickness_share of the thickness; in steps of 0.02. The largest one on the start's ways (crack_ways).
std::vector<double> crossed_shares(const geometry::Body& body, const CrackSurface& surface);

/// The start whose crack leads: it crosses the largest share of its ligament (crossed_shares). Of equals, the
/// one where the first facet at the farthest station opened first; of these the one with the lowest number.
/// -1 where no crack has started.
int leading_notch(const geometry::Body& body, const CrackSurface& surface);

/// The same as far as it follows from crossings alone, of files that do not hold it: the start whose
/// crack arrives at a section at least as far across its ligament as the next section at which any other
/// start's is missing. Nothing where the crossings leave that open, or a start has no ligament.
/// @param position crack starts x sections, NaN where the crack did not arrive
std::optional<int> leading_notch(const geometry::Body& body, const input::Sections& sections,
                                 std::span<const double> position);

/// The crack pattern of a sample, as stored in /samples/pattern.
enum class Pattern : std::int32_t { none = 0, one_crack = 1, two_cracks = 2, other = 3 };

/// How far the cracks of two starts are anti-symmetric: the overlap of one path with the other turned by 180
/// degrees about the middle between the tips, which takes one tip to the other.
///
/// Both paths are main crossings at 50 stations across the ligament. The overlap is the share of the stations
/// reached by one of them at which both are there and no further apart than overlap_distance_share of the
/// width: 1 for paths that are each other's image, 0 when only one crack runs. NaN for ligaments that have no
/// opposite directions, for starts without one, and without any crack.
double path_overlap(const geometry::Body& body, const CrackSurface& surface, int one, int other);

/// The overlap of the two starts whose cracks run farthest (of equals the first ones); NaN for a body with
/// fewer than two.
double pattern_overlap(const geometry::Body& body, const CrackSurface& surface);

/// Pattern by how far cracks run along their ways (crack_ways): one_crack when exactly one is developed and
/// it is a main crack; two_cracks when exactly two are developed and their pattern_overlap is at least
/// min_overlap, or NaN, which it is unless both ways are ligaments; none when no crack has started; other in
/// all other cases. A crack that belongs to no start counts when it covers developed_share of the width: then
/// the pattern is other.
Pattern classify(const geometry::Body& body, const CrackSurface& surface);

/// Largest speed of the crack fronts along their ways (crack_ways) over a window [m/s]; 0 when no front
/// advances by a window during the dynamic phase.
///
/// The front of a start's crack is seen in columns through the thickness, two mean spacings wide. A column
/// goes on when a tetrahedron opens ahead of all before; its place is the mean of its facets, and in between
/// the column's way is linear in time. The front's course is the mean time at which the columns pass a
/// position. What opens in the dynamic phase more than a window ahead of the front counts when the front
/// comes to it, and no speed is taken over a jump across it.
///
/// The largest of many noisy speeds is too large, the more so the shorter the window. So a window's time is
/// read off a line or a parabola, fitted by least squares to a stretch of a window or more (two for a
/// parabola). A longer stretch counts while its scatter hides what the polynomial leaves out: the next
/// polynomial adds no more than two standard errors, and every window in the stretch agrees within
/// speed_standard_errors. Of all stretches, and windows at their ends, the one with the least time plus
/// speed_standard_errors is the fastest; its speed, without the errors, is returned. So a front at constant
/// speed is measured over most of its way, and one whose speed changes over the window.
///
/// Measured less true speed on made fronts, in meshes of 0.2 to 0.6 mm and a ligament of 19 mm, 24 each: bias
/// and standard deviation [%], least to greatest over the meshes. The scatter is that of each tetrahedron's
/// place when it breaks.
///
/// | scatter [spacings] | constant, 1 mm thick | constant, 2 to 5 mm | from 200 to 600 m/s, 1 to 5 mm |
/// |---|---|---|---|
/// | 0 | 0.0, 0.0 | 0.0, 0.0 | -0.4 to 0.1, 0.0 to 0.4 |
/// | 0.15 | 0.0 to 0.1, 0.0 to 0.2 | 0.0 to 0.1, 0.0 to 0.1 | -0.4 to 1.2, 0.2 to 1.3 |
/// | 0.3 | 0.1 to 1.5, 0.1 to 5.6 | 0.0 to 0.2, 0.1 to 0.4 | -0.4 to 2.7, 0.5 to 4.3 |
///
/// The largest ones are at 0.6 mm in 1 mm, a front of one column.
double max_crack_speed(const geometry::Body& body, const CrackSurface& surface);

}  // namespace crackle::analysis
