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

constexpr double share_of_nodes = 5e-3;
constexpr std::int32_t draws_per_node = 16;
constexpr std::size_t n_nearest = 8;
constexpr double rounding = 1e-9;

class StiffNodes {
public:
  StiffNodes(Tessellation& tessellation, std::span<const std::uint8_t> movable,
             const std::function<Point(std::int32_t, std::int32_t)>& draw)
      : tessellation_(tessellation), movable_(movable), draw_(draw), draws_(movable.size(), 0) {}

  std::int64_t redraw() {
    for (const std::int32_t node : find()) {
      if (is_soft(node)) continue;
      redraw(node);
      for (const std::int32_t neighbour : nearest(node)) {
        if (is_soft(node)) break;
        redraw(neighbour);
      }
    }
    return n_moved_;
  }

private:
  /// Sets the limit and returns the nodes above it, ascending.
  std::vector<std::int32_t> find() {
    const std::vector<double> stiffness = tessellation_.stiffness_over_mass();
    std::vector<std::int32_t> nodes(stiffness.size());
    std::iota(nodes.begin(), nodes.end(), 0);
    const auto n_stiff = static_cast<std::ptrdiff_t>(share_of_nodes * static_cast<double>(nodes.size()));
    std::ranges::nth_element(nodes, nodes.begin() + n_stiff, [&](std::int32_t a, std::int32_t b) {
      return std::pair(-stiffness[index(a)], a) < std::pair(-stiffness[index(b)], b);
    });
    limit_ = tessellation_.stiffness_over_mass(nodes[index(n_stiff)]);
    nodes.resize(index(n_stiff));
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
    if (movable_[index(node)] == 0) return;
    const Point before = tessellation_.points()[index(node)];
    const std::vector<std::int32_t> neighbours = tessellation_.neighbours(node);
    Point best = before;
    double least = stiffest(node, neighbours, std::numeric_limits<double>::infinity());
    std::vector<Tetrahedron> bad;  // stays empty
    tessellation_.lift(node);
    for (std::int32_t k = 0; k < draws_per_node; ++k) {
      const Point position = draw_(node, ++draws_[index(node)]);
      if (tessellation_.try_at(position, Tessellation::Trial{}).n_bad > 0) continue;
      if (tessellation_.tried_stiffness_over_mass() > (1 + rounding) * least) continue;
      tessellation_.put(position, bad);
      const double found = stiffest(node, neighbours, least);
      if (found < least) {
        least = found;
        best = position;
      }
      if (least <= limit_) break;
      tessellation_.lift(node);
    }
    if (least > limit_) tessellation_.put(best, bad);
    n_moved_ += best != before;
  }

  Tessellation& tessellation_;
  std::span<const std::uint8_t> movable_;
  const std::function<Point(std::int32_t, std::int32_t)>& draw_;
  std::vector<std::int32_t> draws_;  ///< of each node so far
  double limit_ = 0;
  std::int64_t n_moved_ = 0;
};

}  // namespace

std::int64_t redraw_stiffest(Tessellation& tessellation, std::span<const std::uint8_t> movable,
                             const std::function<Point(std::int32_t, std::int32_t)>& draw) {
  return StiffNodes(tessellation, movable, draw).redraw();
}

}  // namespace crackle::geometry
