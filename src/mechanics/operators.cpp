// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/mechanics/operators.h"

#include <numeric>

namespace crackle::mechanics {

namespace {

Vector difference(const geometry::Point& a, const geometry::Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

}  // namespace

TetrahedronOperator tetrahedron_operator(const geometry::Tetrahedron& nodes,
                                         const std::array<geometry::Point, 4>& x) {
  const Vector d1 = difference(x[1], x[0]);
  const Vector d2 = difference(x[2], x[0]);
  const Vector d3 = difference(x[3], x[0]);
  const Vector n1 = cross(d2, d3);
  const Vector n2 = cross(d3, d1);
  const Vector n3 = cross(d1, d2);
  const double six_volumes = dot(d1, n1);
  TetrahedronOperator t{nodes, {}, six_volumes / 6};
  for (std::size_t i = 0; i < 3; ++i) {
    t.gradient[1][i] = n1[i] / six_volumes;
    t.gradient[2][i] = n2[i] / six_volumes;
    t.gradient[3][i] = n3[i] / six_volumes;
    t.gradient[0][i] = -(t.gradient[1][i] + t.gradient[2][i] + t.gradient[3][i]);
  }
  return t;
}

PdsOperators make_operators(const geometry::Subdomain& subdomain, double density) {
  PdsOperators operators;
  operators.tetrahedra.reserve(subdomain.tetrahedra.size());
  operators.node_mass.assign(static_cast<std::size_t>(subdomain.layout.n_owned), 0.0);
  for (const auto& nodes : subdomain.tetrahedra) {
    std::array<geometry::Point, 4> x{};
    for (std::size_t a = 0; a < 4; ++a) x[a] = subdomain.nodes[index(nodes[a])];
    const auto& t = operators.tetrahedra.emplace_back(tetrahedron_operator(nodes, x));
    for (const auto node : nodes) {
      if (node < subdomain.layout.n_owned) operators.node_mass[index(node)] += density * t.volume / 4;
    }
  }
  return operators;
}

Vector dual_facet_area(const TetrahedronOperator& tetrahedron, int a, int b) {
  const Vector& from = tetrahedron.gradient[index(a)];
  const Vector& to = tetrahedron.gradient[index(b)];
  const double factor = tetrahedron.volume / 4;
  return {factor * (to[0] - from[0]), factor * (to[1] - from[1]), factor * (to[2] - from[2])};
}

NodeTetrahedra node_tetrahedra(const geometry::Subdomain& subdomain) {
  NodeTetrahedra result;
  result.offset.assign(subdomain.nodes.size() + 1, 0);
  for (const auto& nodes : subdomain.tetrahedra) {
    for (const auto node : nodes) ++result.offset[index(node) + 1];
  }
  std::partial_sum(result.offset.begin(), result.offset.end(), result.offset.begin());
  result.tetrahedron.resize(static_cast<std::size_t>(result.offset.back()));
  auto next = result.offset;
  for (std::size_t t = 0; t < subdomain.tetrahedra.size(); ++t) {
    for (const auto node : subdomain.tetrahedra[t]) {
      result.tetrahedron[index(next[index(node)]++)] = static_cast<std::int32_t>(t);
    }
  }
  return result;
}

}  // namespace crackle::mechanics
