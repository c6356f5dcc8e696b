// SPDX-License-Identifier: GPL-3.0-or-later
#include "slabs.h"

#include "crackle/analysis/crack_path.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::analysis {

namespace {

/// The pieces of each of the slabs k, k + 1, ... that ways from piece `start` of slab k pass, over at most
/// min_branch_length slabs.
Way pieces_ahead(const std::vector<Slab>& slabs, std::size_t k, std::size_t start) {
  Way levels{{start}};
  while (levels.size() < min_branch_length && k + levels.size() < slabs.size()) {
    const Slab& slab = slabs[k + levels.size() - 1];
    std::vector<std::size_t> reached;
    for (const std::size_t piece : levels.back()) {
      reached.insert(reached.end(), slab[piece].next.begin(), slab[piece].next.end());
    }
    if (reached.empty()) break;
    sort_out(reached);
    levels.push_back(std::move(reached));
  }
  return levels;
}

}  // namespace

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

std::vector<Way> separate_ways(const std::vector<Slab>& slabs, std::size_t k, const Piece& piece) {
  std::vector<Way> ways;
  for (const std::size_t j : piece.next) {
    Way way = pieces_ahead(slabs, k + 1, j);
    if (way.size() < min_branch_length) continue;
    // A way that meets an earlier one soon is the same branch; it may connect several earlier ones.
    for (std::size_t i = 0; i < ways.size();) {
      bool meet = false;
      for (std::size_t level = 0; level < min_branch_length; ++level) {
        meet = meet || have_common(ways[i][level], way[level]);
      }
      if (!meet) {
        ++i;
        continue;
      }
      for (std::size_t level = 0; level < min_branch_length; ++level) add(way[level], ways[i][level]);
      ways.erase(ways.begin() + static_cast<std::ptrdiff_t>(i));
      i = 0;
    }
    ways.push_back(std::move(way));
  }
  return ways;
}

}  // namespace crackle::analysis
