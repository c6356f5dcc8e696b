// SPDX-License-Identifier: GPL-3.0-or-later
#include "mechanics/operators.h"

#include <numeric>

namespace crackle::mechanics {

PdsOperators make_operators(const geometry::Subdomain& subdomain, const TetrahedronField<double>& density) {
  PdsOperators operators{TetrahedronOperators(subdomain), {}};
  operators.node_mass.assign(static_cast<std::size_t>(subdomain.layout.n_owned), 0.0);
  operators.node_volume.assign(operators.node_mass.size(), 0.0);
  for (std::int32_t number = 0; number < subdomain.n_tetrahedra(); ++number) {
    const TetrahedronOperator t = operators.tetrahedra[index(number)];
    for (const auto node : t.nodes) {
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
