// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cracks/crack_surface.h"
#include "geometry/body.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace crackle::cracks {

/// Shorter cracks do not have a ligament of their own [spacings].
inline constexpr double min_crack_length = 3;
/// Contacts of a crack with its start that are no farther apart than this belong to one root [spacings].
inline constexpr double root_gap = 2;

/// A straight line along which the extent of a start's cracks is measured.
struct CrackLigament {
  std::int32_t start;   ///< number of the crack start to which the cracks belong
  std::int32_t origin;  ///< number of the start that they touched first, see Crack
  /// In the form of a start with a ligament: its tip is the root.
  geometry::CrackStart line;
  std::vector<std::size_t> facets;  ///< of its cracks, in order of breaking
};

/// Which lines cracks are followed along.
enum class Followed {
  ligaments,
  /// Those of whole cracks: a crack that runs into a hole has one ligament with those that continue it behind
  /// the hole (Crack::hole), along the straight line from its root to where the last of them ends.
  through_holes,
  /// Straight lines from the roots of all cracks to where these end: as the ligaments of starts that are not
  /// straight, and from the tip of those that are. A slot's crack need not run along the slot.
  chords,
};

/// The ligaments of the cracks that touched one crack start first (Crack::origin).
///
/// A straight start (CrackStart::is_straight) has its own ligament, with the facets of all its cracks.
///
/// For other starts the ligaments follow from the cracks. A connected crack has a root at each place where it
/// touches the start's faces: the mean of the closest points on these faces to its facets within one spacing.
/// A crack of the free surface has its root on the surface if that is within min_crack_length of where it
/// opened first, otherwise at that place inside the body. Each facet belongs to the nearest root. From the
/// root one ligament leads towards the farthest facet, and another towards the farthest facet behind the
/// root, if any is min_crack_length away: from inside the body, or from a hole no larger than root_gap,
/// cracks run to both sides. A ligament ends where its line leaves the body behind that facet, by
/// Body::outline. There is none if no facet is min_crack_length away from the root.
std::vector<CrackLigament> crack_ligaments(const geometry::Body& body, const CrackSurface& surface,
                                           std::int32_t start, Followed followed = Followed::ligaments);

/// The ligaments of all crack starts, in their order.
std::vector<CrackLigament> crack_ligaments(const geometry::Body& body, const CrackSurface& surface,
                                           Followed followed = Followed::ligaments);

}  // namespace crackle::cracks
