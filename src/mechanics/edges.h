// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/subdomain.h"
#include "mechanics/elasticity.h"
#include "mechanics/operators.h"
#include "mechanics/residual_stiffness.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::mechanics {

/// The node pairs of a subdomain that share a tetrahedron and include an owned node. Every tetrahedron around
/// such a pair is in the subdomain.
struct Edges {
  std::vector<std::array<std::int32_t, 2>> nodes;  ///< local numbers, the smaller first; ascending
  std::vector<std::int32_t> offset;                ///< n_edges + 1, into `tetrahedron`
  std::vector<std::int32_t> tetrahedron;           ///< around each edge, ascending
  std::vector<std::uint8_t> is_inner;              ///< 1 if the tetrahedra form a closed ring around the edge

  std::size_t size() const { return nodes.size(); }
  /// The edges of a tetrahedron, in the order of geometry::dual_facet_nodes; -1 for a pair of ghosts. Looked
  /// up by bisection.
  std::array<std::int32_t, 6> of_tetrahedron(const geometry::Tetrahedron& corners) const;
  /// True if the antisymmetric parts of the couplings cancel as long as all tetrahedra around the edge are
  /// intact: these form a closed ring of one stiffness.
  bool is_symmetric(std::int32_t edge, const ElasticityField& elasticity) const;
  std::span<const std::int32_t> round(std::int32_t edge) const {
    const auto e = static_cast<std::size_t>(edge);
    return {tetrahedron.data() + offset[e], static_cast<std::size_t>(offset[e + 1] - offset[e])};
  }
};
Edges make_edges(const geometry::Subdomain& subdomain);

/// The coupling K_ab = S + [w]x of two nodes: the internal force on a is the sum over its edges of
/// K_ab (u_b - u_a).
///
/// For isotropic elasticity a tetrahedron contributes V (lambda g_a g_b^T + mu g_b g_a^T + mu (g_a . g_b) I);
/// its antisymmetric part is V (lambda - mu) / 2 g_b x g_a, which cancels if tetrahedra of equal stiffness
/// form a closed ring around the edge.
struct EdgeCoupling {
  Symmetric s{};  ///< [N/m]
  Vector w{};     ///< [N/m]
};

/// Sum over the stiffness still carried by the tetrahedra around an edge, in ascending order: bitwise equal
/// on every rank. `w` is exactly 0 if the edge is_symmetric() and all tetrahedra around it are intact.
EdgeCoupling edge_coupling(RecentOperators& operators, const ElasticityField& elasticity, const Edges& edges,
                           const ResidualStiffness& residual_stiffness, std::int32_t edge);

}  // namespace crackle::mechanics
