// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crossings.h"

#include <cstddef>
#include <span>
#include <vector>

namespace crackle::analysis {

/// A connected piece of a crack in one slab, and the pieces of the next slab that share a facet with it.
struct Piece {
  std::vector<std::size_t> facets;  ///< ascending
  std::vector<std::size_t> next;    ///< indices into the next slab, ascending
};
using Slab = std::vector<Piece>;

/// The crack from a crack start cut in slabs of thickness `spacing` along its advance, from the tip on.
std::vector<Slab> cut_in_slabs(const CrackSurface& surface, std::span<const std::size_t> facets,
                               const geometry::CrackStart& start, double spacing, double thickness);

/// A way on: the pieces of the next slabs that it passes, over min_branch_length slabs.
using Way = std::vector<std::vector<std::size_t>>;

/// The ways on from a piece of slab k that are long enough and have no piece in common.
std::vector<Way> separate_ways(const std::vector<Slab>& slabs, std::size_t k, const Piece& piece);

}  // namespace crackle::analysis
