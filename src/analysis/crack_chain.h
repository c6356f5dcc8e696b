// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crossings.h"

#include <cstddef>
#include <span>
#include <vector>

namespace crackle::analysis {

/// The facets of a crack in one slab.
struct ChainLink {
  std::size_t slab;
  Numbers facets;
};

/// The longest chain of connected pieces of a crack, cut perpendicular to a line into slabs that start at its
/// tip; among equals the one nearest to the tip. In a slab, facets form pieces as in section_crossings;
/// pieces of neighbouring slabs are connected if they share a facet.
/// @param spacing thickness of a slab [m]
/// @param thickness of the body [m]
/// @param from_first start in the first slab that has pieces
std::vector<ChainLink> longest_chain(const CrackSurface& surface, std::span<const std::size_t> facets,
                                     const geometry::CrackStart& line, double spacing, double thickness,
                                     bool from_first);

}  // namespace crackle::analysis
