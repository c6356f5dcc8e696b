// SPDX-License-Identifier: GPL-3.0-or-later
// How cracks grow from their notches: branching and speed.
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

Trace extent(const CrackFacet& facet, std::size_t number, std::size_t across) {
  Trace box{{facet.corner[0][0], facet.corner[0][0]},
            {facet.corner[0][across], facet.corner[0][across]},
            local_spacing(facet),
            facet.time,
            number};
  for (const geometry::Point& corner : facet.corner) {
    box.x[0] = std::min(box.x[0], corner[0]);
    box.x[1] = std::max(box.x[1], corner[0]);
    box.across[0] = std::min(box.across[0], corner[across]);
    box.across[1] = std::max(box.across[1], corner[across]);
  }
  return box;
}

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
    const Trace box = extent(facet, i, static_cast<std::size_t>(frame.across));
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

/// A crack front's mean position over the thickness, each time it moved; times strictly ascending.
struct FrontPosition {
  double time;     ///< [s]
  double advance;  ///< from the notch's tip [m]
};

/// The first entry is the front at the start of the dynamic phase.
std::vector<FrontPosition> front_history(const CrackSurface& surface, std::span<const std::size_t> facets,
                                         const NotchFrame& frame, double spacing, double thickness) {
  const auto n_columns = std::max<std::size_t>(1, static_cast<std::size_t>(thickness / (2 * spacing)));
  std::vector<double> farthest(n_columns, 0.0);
  std::vector<FrontPosition> history{{0, 0}};
  for (const std::size_t i : facets) {  // in order of breaking, hence of time
    const CrackFacet& facet = surface.facets[i];
    const Trace box = extent(facet, i, static_cast<std::size_t>(frame.across));
    double advance = 0;
    for (const geometry::Point& corner : facet.corner) {
      advance += frame.advance(corner[static_cast<std::size_t>(frame.axis)]) / 4;
    }
    const auto column_of = [&](double x) {
      const double column = std::floor(x / thickness * static_cast<double>(n_columns));
      return static_cast<std::size_t>(std::clamp(column, 0.0, static_cast<double>(n_columns - 1)));
    };
    const std::size_t last = column_of(box.x[1]);
    for (std::size_t c = column_of(box.x[0]); c <= last; ++c) farthest[c] = std::max(farthest[c], advance);
    double mean = 0;
    for (const double value : farthest) mean += value / static_cast<double>(n_columns);
    const double time = std::max(facet.time, 0.0);
    if (mean <= history.back().advance) continue;
    if (time > history.back().time) history.push_back({time, mean});
    history.back().advance = mean;
  }
  return history;
}

/// The time at which a front passes a position between its first and its last.
double passing_time(const std::vector<FrontPosition>& front, double advance) {
  std::size_t k = 1;
  while (k + 1 < front.size() && front[k].advance < advance) ++k;
  const double share = (advance - front[k - 1].advance) / (front[k].advance - front[k - 1].advance);
  return front[k - 1].time + share * (front[k].time - front[k - 1].time);
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

double max_crack_speed(const geometry::Body& body, const CrackSurface& surface) {
  double largest = 0;
  for (int notch = 0; notch < body.n_notches(); ++notch) {
    const std::vector<std::size_t> facets = facets_of_notch(surface, notch);
    if (facets.empty()) continue;
    const NotchFrame frame = notch_frame(body, notch);
    const double spacing = mean_spacing(surface, facets);
    const std::vector<FrontPosition> front = front_history(surface, facets, frame, spacing, body.size()[0]);
    const double window = std::max(speed_window_share * frame.ligament, speed_window_spacings * spacing);
    // The time over a window is piecewise linear in its position: its least value is at one of the front's
    // recorded positions, at the window's start or at its end.
    const double first = front.front().advance;
    const double last = front.back().advance;
    if (last - first < window) continue;
    for (const FrontPosition& position : front) {
      for (const double start : {position.advance, position.advance - window}) {
        if (start < first || start + window > last) continue;
        const double time = passing_time(front, start + window) - passing_time(front, start);
        largest = std::max(largest, window / time);
      }
    }
  }
  return largest;
}

}  // namespace crackle::analysis
