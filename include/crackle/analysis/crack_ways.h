// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/crack_surface.h"
#include "crackle/geometry/body.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace crackle::analysis {

/// Cracks that run less far do not have a way of their own [spacings].
inline constexpr double min_way_length = 3;
/// Places where a crack touches its start are one root when they are no further apart than this [spacings].
inline constexpr double root_gap = 2;

/// A straight way along which cracks of a start are measured.
struct CrackWay {
  std::int32_t notch;  ///< number of the crack start
  /// The way as that of a start with a ligament: tip is its root.
  geometry::CrackStart line;
  std::vector<std::size_t> facets;  ///< of its cracks, in order of breaking
};

/// The ways of one crack start.
///
/// A start with a ligament has exactly one, the ligament, with the facets of all its cracks.
///
/// The ways from another one follow from the cracks themselves. A connected crack has a root at each place
/// where it touches the start's faces: the mean of the points of these faces next to its facets that are no
/// further from them than a spacing. A crack of the free surface has its root at the place of the surface
/// within min_way_length of where it opened first, else there, inside the body. Each facet belongs to the
/// nearest root. From the root a way leads towards the farthest facet, and another one towards the farthest
/// of those behind the root, if there are any min_way_length away: from inside the body, or out of a hole not
/// larger than root_gap, cracks run to both sides. Its ligament ends where it leaves the body behind that
/// facet, by Body::outline. Where nothing is min_way_length away from the root there is no way.
std::vector<CrackWay> crack_ways(const geometry::Body& body, const CrackSurface& surface, std::int32_t start);

/// Those of all crack starts, in their order.
std::vector<CrackWay> crack_ways(const geometry::Body& body, const CrackSurface& surface);

}  // namespace crackle::analysis
