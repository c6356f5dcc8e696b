// SPDX-License-Identifier: GPL-3.0-or-later
#include "mechanics/edges.h"

#include "common/index.h"
#include "geometry/dual_facets.h"

#include <algorithm>
#include <numeric>

namespace crackle::mechanics {

namespace {

/// One side of a tetrahedron, before it is assigned to its edge.
struct Side {
  std::int32_t larger;
  std::int32_t place;  // 6 x tetrahedron + number of the side
};

/// The edge of two nodes, or -1.
std::int32_t between(const Edges& edges, std::int32_t one, std::int32_t other) {
  const auto [a, b] = std::minmax(one, other);
  const std::array<std::int32_t, 2> pair{a, b};
  const auto place = std::ranges::lower_bound(edges.nodes, pair);
  return place != edges.nodes.end() && *place == pair ? static_cast<std::int32_t>(place - edges.nodes.begin())
                                                      : -1;
}

}  // namespace

Edges make_edges(const geometry::Subdomain& subdomain) {
  Edges edges;
  // Bucket by the smaller node, then sort the few sides of each bucket.
  std::vector<std::int32_t> begin(subdomain.nodes.size() + 1, 0);
  const auto for_sides = [&](const auto& visit) {
    for (std::size_t t = 0; t < subdomain.tetrahedra.size(); ++t) {
      for (std::size_t k = 0; k < 6; ++k) {
        const auto [i, j] = geometry::dual_facet_nodes[k];
        const auto [a, b] = std::minmax(subdomain.tetrahedra[t][i], subdomain.tetrahedra[t][j]);
        if (a < subdomain.layout.n_owned) visit(a, Side{b, static_cast<std::int32_t>(6 * t + k)});
      }
    }
  };
  for_sides([&](std::int32_t a, const Side&) { ++begin[index(a) + 1]; });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Side> sides(index(begin.back()));
  auto next = begin;
  for_sides([&](std::int32_t a, const Side& side) { sides[index(next[index(a)]++)] = side; });

  edges.offset.push_back(0);
  edges.tetrahedron.reserve(sides.size());
  for (std::int32_t a = 0; a < subdomain.layout.n_owned; ++a) {
    const auto first = sides.begin() + begin[index(a)];
    const auto last = sides.begin() + begin[index(a) + 1];
    std::sort(first, last, [](const Side& x, const Side& y) {
      return x.larger != y.larger ? x.larger < y.larger : x.place < y.place;
    });
    for (auto side = first; side != last; ++side) {
      if (side == first || side->larger != (side - 1)->larger) {
        if (!edges.nodes.empty()) edges.offset.push_back(static_cast<std::int32_t>(edges.tetrahedron.size()));
        edges.nodes.push_back({a, side->larger});
      }
      edges.tetrahedron.push_back(side->place / 6);
    }
  }
  if (!edges.nodes.empty()) edges.offset.push_back(static_cast<std::int32_t>(edges.tetrahedron.size()));
  edges.nodes.shrink_to_fit();
  edges.offset.shrink_to_fit();

  edges.is_inner.assign(edges.size(), 1);
  for (const auto& triangle : subdomain.boundary) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t edge = between(edges, triangle.nodes[k], triangle.nodes[(k + 1) % 3]);
      if (edge >= 0) edges.is_inner[index(edge)] = 0;
    }
  }
  return edges;
}

std::array<std::int32_t, 6> Edges::of_tetrahedron(const geometry::Tetrahedron& corners) const {
  std::array<std::int32_t, 6> result{};
  for (std::size_t k = 0; k < 6; ++k) {
    const auto [i, j] = geometry::dual_facet_nodes[k];
    result[k] = between(*this, corners[i], corners[j]);
  }
  return result;
}

bool Edges::is_symmetric(std::int32_t edge, const ElasticityField& elasticity) const {
  if (is_inner[index(edge)] == 0) return false;
  const auto ring = round(edge);
  return elasticity.is_uniform() ||
         std::ranges::all_of(ring, [&](std::int32_t t) { return elasticity[t] == elasticity[ring.front()]; });
}

EdgeCoupling edge_coupling(RecentOperators& operators, const ElasticityField& elasticity, const Edges& edges,
                           const ResidualStiffness& residual_stiffness, std::int32_t edge) {
  EdgeCoupling k;
  const auto [first, second] = edges.nodes[index(edge)];
  bool is_whole = edges.is_symmetric(edge, elasticity);
  for (const auto number : edges.round(edge)) {
    const auto& [lambda, mu] = elasticity[number];
    const TetrahedronOperator& t = operators[number];
    const auto corner = [&](std::int32_t node) {
      return static_cast<std::size_t>(std::ranges::find(t.nodes, node) - t.nodes.begin());
    };
    if (!residual_stiffness.is_intact(number)) {
      is_whole = false;
      if (!residual_stiffness.carries(number)) continue;
      // Which node has the smaller local number differs between ranks, and with it the order of summation:
      // use the tetrahedron's own order. The other block is the transpose.
      const auto [i, j] = std::minmax({corner(first), corner(second)});
      const Matrix m = residual_stiffness.partial(number).coupling(i, j);
      const double half = 0.5 * t.volume;
      const double skew_half = i == corner(first) ? half : -half;
      for (std::size_t c = 0; c < 3; ++c) k.s[c] += t.volume * m[c][c];
      k.s[3] += half * (m[1][2] + m[2][1]);
      k.s[4] += half * (m[0][2] + m[2][0]);
      k.s[5] += half * (m[0][1] + m[1][0]);
      k.w[0] += skew_half * (m[2][1] - m[1][2]);
      k.w[1] += skew_half * (m[0][2] - m[2][0]);
      k.w[2] += skew_half * (m[1][0] - m[0][1]);
      continue;
    }
    const Vector& a = t.gradient[corner(first)];
    const Vector& b = t.gradient[corner(second)];
    const double shear = t.volume * mu * dot(a, b);
    const double mean = 0.5 * t.volume * (lambda + mu);
    k.s[0] += 2 * mean * (a[0] * b[0]) + shear;
    k.s[1] += 2 * mean * (a[1] * b[1]) + shear;
    k.s[2] += 2 * mean * (a[2] * b[2]) + shear;
    k.s[3] += mean * (a[1] * b[2] + b[1] * a[2]);
    k.s[4] += mean * (a[0] * b[2] + b[0] * a[2]);
    k.s[5] += mean * (a[0] * b[1] + b[0] * a[1]);
    const Vector turned = cross(b, a);
    const double half_difference = 0.5 * t.volume * (lambda - mu);
    for (std::size_t i = 0; i < 3; ++i) k.w[i] += half_difference * turned[i];
  }
  if (is_whole) k.w = {};
  return k;
}

}  // namespace crackle::mechanics
