// SPDX-License-Identifier: GPL-3.0-or-later
#include "crack_chain.h"

#include "crackle/common/index.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::analysis {

namespace {

/// A connected piece of a crack in one slab, with the pieces of the next slab that share a facet with it.
struct Piece {
  Numbers facets;
  Numbers next;  ///< indices into the next slab
};
using Slab = std::vector<Piece>;

/// Facets of a crack, cut into slabs of thickness `spacing` along its advance, starting at the tip.
std::vector<Slab> cut_in_slabs(const CrackSurface& surface, std::span<const std::size_t> facets,
                               const geometry::CrackStart& start, double spacing, double thickness) {
  const auto n_slabs = static_cast<std::size_t>(std::ceil(start.ligament / spacing));
  std::vector<std::vector<Trace>> traces(n_slabs);
  for (const std::size_t i : facets) {
    const auto [low, high] = advances(surface.facets[i], start);
    if (high < 0 || low >= start.ligament) continue;
    const auto first = static_cast<std::size_t>(std::max(0.0, std::floor(low / spacing)));
    const auto last = std::min(static_cast<std::size_t>(std::floor(high / spacing)), n_slabs - 1);
    const Trace box = extent(surface, i, start.across);
    for (std::size_t k = first; k <= last; ++k) traces[k].push_back(box);
  }
  std::vector<Slab> slabs(n_slabs);
  for (std::size_t k = 0; k < n_slabs; ++k) {
    for (const auto& members : group(traces[k], thickness)) {
      Piece piece;
      for (const std::size_t i : members) piece.facets.push_back(traces[k][i].facet);
      slabs[k].push_back(std::move(piece));
    }
  }
  for (std::size_t k = 0; k + 1 < n_slabs; ++k) {
    for (Piece& piece : slabs[k]) {
      for (std::size_t j = 0; j < slabs[k + 1].size(); ++j) {
        if (have_common(piece.facets, slabs[k + 1][j].facets)) piece.next.push_back(j);
      }
    }
  }
  return slabs;
}

}  // namespace

std::vector<ChainLink> longest_chain(const CrackSurface& surface, std::span<const std::size_t> facets,
                                     const geometry::CrackStart& line, double spacing, double thickness,
                                     bool from_first) {
  std::vector<Slab> slabs = cut_in_slabs(surface, facets, line, spacing, thickness);
  std::vector<std::vector<std::size_t>> n_ahead(slabs.size());  // slabs of the longest chain from each piece
  const auto longest = [&](std::size_t slab, const Numbers& pieces) {
    return *std::ranges::max_element(pieces, {}, [&](std::size_t piece) { return n_ahead[slab][piece]; });
  };
  std::size_t slab = slabs.size(), first = 0;
  for (std::size_t k = slabs.size(); k-- > 0;) {
    for (const Piece& piece : slabs[k])
      n_ahead[k].push_back(1 + (piece.next.empty() ? 0 : n_ahead[k + 1][longest(k + 1, piece.next)]));
    if (slabs[k].empty()) continue;
    const auto best = std::ranges::max_element(n_ahead[k]);
    if (!from_first && slab < slabs.size() && *best < n_ahead[slab][first]) continue;
    slab = k;
    first = static_cast<std::size_t>(best - n_ahead[k].begin());
  }
  std::vector<ChainLink> chain;
  for (std::size_t piece = first; slab < slabs.size(); ++slab) {
    Piece& here = slabs[slab][piece];
    chain.push_back({slab, std::move(here.facets)});
    if (here.next.empty()) break;
    piece = longest(slab + 1, here.next);
  }
  return chain;
}

}  // namespace crackle::analysis
