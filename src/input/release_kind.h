// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"

#include <array>
#include <cstddef>

namespace crackle::input {

/// How a breaking tetrahedron gives way; by fracture::Release.
enum class Release { element, facet, softening };

struct ReleaseTraits {
  Release kind;
  const char* name;  ///< as spelled in the input
  /// Dissipates the toughness in steps from the strength on, so that it needs both.
  bool softens;
  bool by_cuts;  ///< opens one cut at a time
  /// c of toughness_factor() at Poisson's ratio 0.
  double toughness_factor;
};

/// All kinds, in the order of the enumeration.
inline constexpr std::array release_kinds{
    ReleaseTraits{Release::element, "element", false, false, 0.91},
    ReleaseTraits{Release::facet, "facet", false, true, 0.97},
    ReleaseTraits{Release::softening, "softening", true, false, 0.91},
};

static_assert([] {
  for (std::size_t i = 0; i < release_kinds.size(); ++i)
    if (static_cast<std::size_t>(release_kinds[i].kind) != i) return false;
  return true;
}());

constexpr const ReleaseTraits& traits(Release kind) {
  return release_kinds[index(kind)];
}

}  // namespace crackle::input
