// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_path.h"

#include "crossings.h"

#include <algorithm>
#include <cmath>

namespace crackle::analysis {

namespace {

/// A connected piece of a crack in one slab, and the pieces of the next slab that share a facet with it.
struct Piece {
  std::vector<std::size_t> facets;  ///< ascending
  std::vector<std::size_t> next;    ///< indices into the next slab, ascending
};
using Slab = std::vector<Piece>;

bool share_an_element(const std::vector<std::size_t>& a, const std::vector<std::size_t>& b) {
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (*i == *j) return true;
    *i < *j ? ++i : ++j;
  }
  return false;
}

/// A notch's crack cut in slabs along its advance, from the tip on.
std::vector<Slab> cut_in_slabs(const CrackSurface& surface, std::span<const std::size_t> facets,
                               const NotchFrame& frame, double spacing, double thickness) {
  const auto axis = static_cast<std::size_t>(frame.axis);
  const auto n_slabs = static_cast<std::size_t>(std::ceil(frame.ligament / spacing));
  std::vector<std::vector<Trace>> traces(n_slabs);
  for (const std::size_t i : facets) {
    const CrackFacet& facet = surface.facets[i];
    double low = frame.advance(facet.corner[0][axis]);
    double high = low;
    for (const geometry::Point& corner : facet.corner) {
      low = std::min(low, frame.advance(corner[axis]));
      high = std::max(high, frame.advance(corner[axis]));
    }
    if (high < 0 || low >= frame.ligament) continue;
    const auto first = static_cast<std::size_t>(std::max(0.0, std::floor(low / spacing)));
    const auto last = std::min(static_cast<std::size_t>(std::floor(high / spacing)), n_slabs - 1);
    const Trace box = extent(surface, i, frame.across);
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
        if (share_an_element(piece.facets, slabs[k + 1][j].facets)) piece.next.push_back(j);
      }
    }
  }
  return slabs;
}

/// The pieces of each of the slabs k, k + 1, ... that ways from piece `start` of slab k pass, over at most
/// min_branch_length slabs.
std::vector<std::vector<std::size_t>> pieces_ahead(const std::vector<Slab>& slabs, std::size_t k,
                                                   std::size_t start) {
  std::vector<std::vector<std::size_t>> levels{{start}};
  while (levels.size() < min_branch_length && k + levels.size() < slabs.size()) {
    const Slab& slab = slabs[k + levels.size() - 1];
    std::vector<std::size_t> reached;
    for (const std::size_t piece : levels.back()) {
      reached.insert(reached.end(), slab[piece].next.begin(), slab[piece].next.end());
    }
    if (reached.empty()) break;
    std::sort(reached.begin(), reached.end());
    reached.erase(std::unique(reached.begin(), reached.end()), reached.end());
    levels.push_back(std::move(reached));
  }
  return levels;
}

/// Number of separate ways on from a piece of slab k.
int count_branches(const std::vector<Slab>& slabs, std::size_t k, const Piece& piece) {
  std::vector<std::vector<std::vector<std::size_t>>> ways;
  for (const std::size_t j : piece.next) {
    auto way = pieces_ahead(slabs, k + 1, j);
    if (way.size() < min_branch_length) continue;
    // A way that meets an earlier one soon is the same branch; it may connect several earlier ones.
    for (std::size_t i = 0; i < ways.size();) {
      bool meet = false;
      for (std::size_t level = 0; level < min_branch_length; ++level) {
        meet = meet || share_an_element(ways[i][level], way[level]);
      }
      if (!meet) {
        ++i;
        continue;
      }
      for (std::size_t level = 0; level < min_branch_length; ++level) {
        std::vector<std::size_t> both;
        std::set_union(way[level].begin(), way[level].end(), ways[i][level].begin(), ways[i][level].end(),
                       std::back_inserter(both));
        way[level] = std::move(both);
      }
      ways.erase(ways.begin() + static_cast<std::ptrdiff_t>(i));
      i = 0;
    }
    ways.push_back(std::move(way));
  }
  return static_cast<int>(ways.size());
}

}  // namespace

std::int32_t count_bifurcations(const geometry::Body& body, const CrackSurface& surface) {
  std::int32_t n_bifurcations = 0;
  for (int notch = 0; notch < body.n_notches(); ++notch) {
    const std::vector<std::size_t> facets = facets_of_notch(surface, notch);
    if (facets.empty()) continue;
    const std::vector<Slab> slabs = cut_in_slabs(surface, facets, notch_frame(body, notch),
                                                 mean_spacing(surface, facets), body.size()[0]);
    for (std::size_t k = 0; k < slabs.size(); ++k) {
      for (const Piece& piece : slabs[k]) {
        n_bifurcations += std::max(0, count_branches(slabs, k, piece) - 1);
      }
    }
  }
  return n_bifurcations;
}

}  // namespace crackle::analysis
