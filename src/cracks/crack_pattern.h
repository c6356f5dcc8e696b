// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cracks/crack_surface.h"

#include <cstdint>
#include <vector>

/// Which crack leads, and the pattern that the cracks of a sample form.
namespace crackle::cracks {

/// A crack that crosses this share of its ligament is developed.
inline constexpr double developed_share = 0.4;
/// A developed crack that crosses this share of the ligament is a main crack.
inline constexpr double through_share = 0.6;
/// A crack that crosses less than this share of the ligament has not started.
inline constexpr double started_share = 0.1;
/// Two paths overlap where they are no farther apart than this share of the body's width.
inline constexpr double overlap_distance_share = 0.1;
/// Two developed cracks are (anti-)symmetric if their paths overlap by at least this share.
inline constexpr double min_overlap = 0.3;

/// Share of its ligament that the crack from each start crosses, up to the farthest station where it covers
/// min_thickness_share of the thickness; in steps of 0.02. The largest value over the start's ligaments
/// (Followed::through_holes).
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

/// Pattern by how far cracks run along their ligaments (Followed::through_holes): one_crack if exactly one is
/// developed and it is a main crack; two_cracks if exactly two are developed and their pattern_overlap is at
/// least min_overlap, or NaN because they are not those of straight starts; none if no crack has started;
/// other in all other cases, and if a crack that belongs to no start covers developed_share of the width.
Pattern classify(const geometry::Body& body, const CrackSurface& surface);

}  // namespace crackle::cracks
