// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/mechanics/operators.h"

#include <numeric>

namespace crackle::mechanics {

TetrahedronOperator tetrahedron_operator(const geometry::Tetrahedron& nodes,
                                         const std::array<geometry::Point, 4>& x) {
  const Vector d1 = x[1] - x[0];
  const Vector d2 = x[2] - x[0];
  const Vector d3 = x[3] - x[0];
  const Vector n1 = cross(d2, d3);
  const Vector n2 = cross(d3, d1);
  const Vector n3 = cross(d1, d2);
  const double six_volumes = dot(d1, n1);
  TetrahedronOperator t{nodes, {}, six_volumes / 6};
  t.gradient[1] = n1 / six_volumes;
  t.gradient[2] = n2 / six_volumes;
  t.gradient[3] = n3 / six_volumes;
  t.gradient[0] = -1 * (t.gradient[1] + t.gradient[2] + t.gradient[3]);
  return t;
}

PdsOperators make_operators(const geometry::Subdomain& subdomain, const TetrahedronField<double>& density) {
  PdsOperators operators;
  operators.tetrahedra.reserve(subdomain.tetrahedra.size());
  operators.node_mass.assign(static_cast<std::size_t>(subdomain.layout.n_owned), 0.0);
  operators.node_volume.assign(operators.node_mass.size(), 0.0);
  for (std::int32_t number = 0; number < subdomain.n_tetrahedra(); ++number) {
    const geometry::Tetrahedron& nodes = subdomain.tetrahedra[index(number)];
    std::array<geometry::Point, 4> x{};
    for (std::size_t a = 0; a < 4; ++a) x[a] = subdomain.nodes[index(nodes[a])];
    const auto& t = operators.tetrahedra.emplace_back(tetrahedron_operator(nodes, x));
    for (const auto node : nodes) {
      if (node >= subdomain.layout.n_owned) continue;
      operators.node_mass[index(node)] += density[number] * t.volume / 4;
      operators.node_volume[index(node)] += t.volume / 4;
    }
  }
  return operators;
}

double stiffness_bound(const PdsOperators& operators, const ElasticityField& elasticity) {
  double largest = 0;
  for (std::size_t i = 0; i < operators.tetrahedra.size(); ++i) {
    const auto& t = operators.tetrahedra[i];
    const auto& [lambda, mu] = elasticity[static_cast<std::int32_t>(i)];
    double steepest = 0;
    for (const auto& g : t.gradient) steepest = std::max(steepest, dot(g, g));
    largest = std::max(largest, t.volume * (std::abs(lambda) + 2 * mu) * steepest);
  }
  return largest;
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
