// SPDX-License-Identifier: GPL-3.0-or-later
#include "redraw_stiffest.h"

#include "common/index.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

namespace crackle::geometry {

namespace {

/// Nodes that count as outliers. Twice as many would lengthen steps by a few percent more.
constexpr double share_of_nodes = 1e-2;
constexpr std::int32_t draws_per_node = 16;
constexpr std::size_t n_nearest = 8;  // with three, up to twice as many nodes stay above the limit
/// Between sums over the same cells in another order.
constexpr double rounding = 1e-9;
/// A trial may stop at the first bad cell.
constexpr Tessellation::Trial no_bad_cell{1, 2};

class StiffNodes {
public:
  StiffNodes(Tessellation& tessellation, const MotherPoints& base,
             const std::function<Point(std::int32_t, std::int32_t)>& draw)
      : tessellation_(tessellation), base_(base), draw_(draw), draws_(base.size(), 0) {}

  /// @return number of nodes that have moved
  std::int64_t soften() {
    const std::vector<Point> before(tessellation_.points().begin(), tessellation_.points().end());
    for (const std::int32_t node : find()) {
      if (is_soft(node)) continue;
      redraw(node);
      for (const std::int32_t neighbour : nearest(node)) {
        if (is_soft(node)) break;
        redraw(neighbour);
      }
    }
    std::int64_t n_moved = 0;
    for (std::size_t i = 0; i < before.size(); ++i) n_moved += before[i] != tessellation_.points()[i];
    return n_moved;
  }

private:
  /// Finds the nodes that are outliers for their spacing, so that as few are chosen where the mesh is fine as
  /// elsewhere, and sets the limit: the stiffest of the others.
  /// @return the outliers above it, ascending
  std::vector<std::int32_t> find() {
    const std::vector<double> stiffness = tessellation_.stiffness_over_mass();
    const auto relative = [&](std::int32_t node) {
      const double spacing = base_.spacing[index(node)];
      return stiffness[index(node)] * spacing * spacing;
    };
    std::vector<std::int32_t> nodes(stiffness.size());
    std::iota(nodes.begin(), nodes.end(), 0);
    const auto n_outliers = static_cast<std::ptrdiff_t>(share_of_nodes * static_cast<double>(nodes.size()));
    const auto first_of_others = nodes.begin() + n_outliers;
    std::ranges::nth_element(nodes, first_of_others, [&](std::int32_t a, std::int32_t b) {
      return std::pair(-relative(a), a) < std::pair(-relative(b), b);
    });
    const std::int32_t stiffest =
        *std::max_element(first_of_others, nodes.end(), [&](std::int32_t a, std::int32_t b) {
          return std::pair(stiffness[index(a)], a) < std::pair(stiffness[index(b)], b);
        });
    limit_ = tessellation_.stiffness_over_mass(stiffest);
    nodes.erase(first_of_others, nodes.end());
    std::erase_if(nodes, [this](std::int32_t node) { return is_soft(node); });
    std::ranges::sort(nodes);
    return nodes;
  }

  bool is_soft(std::int32_t node) const { return tessellation_.stiffness_over_mass(node) <= limit_; }

  std::vector<std::int32_t> nearest(std::int32_t node) const {
    std::vector<std::pair<double, std::int32_t>> by_distance;
    for (const std::int32_t neighbour : tessellation_.neighbours(node))
      by_distance.emplace_back(
          norm(tessellation_.points()[index(neighbour)] - tessellation_.points()[index(node)]), neighbour);
    const std::size_t n = std::min(n_nearest, by_distance.size());
    std::ranges::partial_sort(by_distance, by_distance.begin() + static_cast<std::ptrdiff_t>(n));
    std::vector<std::int32_t> result;
    for (std::size_t k = 0; k < n; ++k) result.push_back(by_distance[k].second);
    return result;
  }

  /// The stiffest of a node, its neighbours and further nodes; stops at `enough`.
  double stiffest(std::int32_t node, std::span<const std::int32_t> further, double enough) const {
    double result = tessellation_.stiffness_over_mass(node);
    const auto look_at = [&](std::span<const std::int32_t> nodes) {
      for (std::size_t i = 0; i < nodes.size() && result < enough; ++i)
        result = std::max(result, tessellation_.stiffness_over_mass(nodes[i]));
    };
    look_at(further);
    if (result < enough) look_at(tessellation_.neighbours(node));
    return result;
  }

  void redraw(std::int32_t node) {
    if (base_.movable[index(node)] == 0) return;
    const std::vector<std::int32_t> neighbours = tessellation_.neighbours(node);
    double least = stiffest(node, {}, std::numeric_limits<double>::infinity());
    if (least <= limit_) return;
    Point best = tessellation_.points()[index(node)];
    std::vector<Tetrahedron> bad;  // stays empty
    tessellation_.lift(node);
    for (std::int32_t k = 0; k < draws_per_node; ++k) {
      const Point position = draw_(node, ++draws_[index(node)]);
      if (tessellation_.try_at(position, no_bad_cell).n_bad > 0 ||
          tessellation_.tried_stiffness_over_mass() > (1 + rounding) * least)
        continue;
      tessellation_.put(position, bad);
      const double found = stiffest(node, neighbours, least);
      if (found <= limit_) return;
      if (found < least) {
        least = found;
        best = position;
      }
      tessellation_.lift(node);
    }
    tessellation_.put(best, bad);
  }

  Tessellation& tessellation_;
  const MotherPoints& base_;
  const std::function<Point(std::int32_t, std::int32_t)>& draw_;
  std::vector<std::int32_t> draws_;  // each node's number of draws so far
  double limit_ = 0;
};

}  // namespace

std::int64_t redraw_stiffest(Tessellation& tessellation, const MotherPoints& base,
                             const std::function<Point(std::int32_t, std::int32_t)>& draw) {
  return StiffNodes(tessellation, base, draw).soften();
}

}  // namespace crackle::geometry
