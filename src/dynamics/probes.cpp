// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/probes.h"

#include "crackle/common/index.h"
#include "crackle/common/real.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/collectives.h"
#include "crackle/parallel/exact_sum.h"

#include <algorithm>
#include <array>
#include <limits>

namespace crackle::dynamics {

namespace {

using Coordinates = std::array<double, 4>;  // barycentric

/// A candidate tetrahedron for a point, with its number in the realization.
struct Found {
  double inside = -infinity;  // smallest barycentric coordinate
  std::int64_t number = std::numeric_limits<std::int64_t>::max();
};

Coordinates coordinates_of(const mechanics::TetrahedronOperator& t, const std::vector<geometry::Point>& nodes,
                           const geometry::Point& p) {
  // The shape functions are linear, with known gradients.
  Coordinates n{};
  double rest = 1;
  const geometry::Point from_first = p - nodes[index(t.nodes[0])];
  for (std::size_t a = 1; a < 4; ++a) {
    n[a] = dot(t.gradient[a], from_first);
    rest -= n[a];
  }
  n[0] = rest;
  return n;
}

Found find(const geometry::Subdomain& subdomain, const mechanics::PdsOperators& operators,
           const geometry::Point& p) {
  Found best;
  for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t) {
    if (subdomain.counted[index(t)] == 0) continue;
    const auto n = coordinates_of(operators.tetrahedra[index(t)], subdomain.nodes, p);
    const double inside = *std::ranges::min_element(n);
    if (inside > best.inside) best = {inside, subdomain.tetrahedron_number[index(t)]};
  }
  return best;
}

}  // namespace

Probes::Probes(const parallel::Communicator& group, const fracture::BreakableBody& body,
               const std::vector<input::Probe>& probes)
    : group_(&group), body_(&body), places_(probes.size()) {
  const geometry::Subdomain& subdomain = body.subdomain();
  const mechanics::PdsOperators& operators = body.operators();
  const auto round_node = mechanics::node_tetrahedra(subdomain);
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const Found mine = find(subdomain, operators, probes[i].at);
    parallel::agree(group);
    const double inside = parallel::all_reduce(group, mine.inside, MPI_MAX);
    const auto number = parallel::all_reduce(
        group, mine.inside == inside ? mine.number : std::numeric_limits<std::int64_t>::max(), MPI_MIN);
    // Every rank that owns one of its nodes holds the tetrahedron.
    std::array<std::int32_t, 4> nodes{-1, -1, -1, -1};
    Coordinates weight{};
    if (const auto local = subdomain.local_number(number); local >= 0) {
      const auto& t = operators.tetrahedra[index(local)];
      weight = coordinates_of(t, subdomain.nodes, probes[i].at);
      double sum = 0;
      for (double& n : weight) sum += n = std::max(n, 0.0);
      for (double& n : weight) n /= sum;
      nodes = t.nodes;
    }
    for (std::size_t a = 0; a < 4; ++a) {
      if (nodes[a] < 0 || nodes[a] >= subdomain.layout.n_owned) continue;
      places_[i].nodes.emplace_back(nodes[a], weight[a]);
      // The owner of a node holds all tetrahedra around it.
      double volume = 0;
      for (const auto t : round_node[nodes[a]]) volume += operators.tetrahedra[index(t)].volume;
      for (const auto t : round_node[nodes[a]])
        places_[i].tetrahedra.emplace_back(t, weight[a] * operators.tetrahedra[index(t)].volume / volume);
    }
  }
}

std::vector<ProbeValue> Probes::read(const parallel::NodeField& displacement,
                                     const parallel::NodeField* velocity) const {
  std::vector<ProbeValue> values(places_.size());
  std::vector<double> terms;
  const auto u = displacement.local();
  const auto at_nodes = [&](const Place& place, std::span<const double> field, std::size_t component) {
    terms.clear();
    for (const auto& [node, weight] : place.nodes)
      terms.push_back(weight * field[3 * index(node) + component]);
    return parallel::exact_sum(*group_, terms);
  };
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Place& place = places_[i];
    for (std::size_t c = 0; c < 3; ++c) {
      values[i].displacement[c] = at_nodes(place, u, c);
      if (velocity != nullptr) values[i].velocity[c] = at_nodes(place, velocity->owned(), c);
    }
    std::vector<mechanics::Symmetric> stresses;
    for (const auto& [t, weight] : place.tetrahedra)
      stresses.push_back(body_->residual_stiffness().stress(t, body_->strain(t, u)));
    for (std::size_t c = 0; c < values[i].stress.size(); ++c) {
      terms.clear();
      for (std::size_t k = 0; k < stresses.size(); ++k)
        terms.push_back(place.tetrahedra[k].second * stresses[k][c]);
      values[i].stress[c] = parallel::exact_sum(*group_, terms);
    }
  }
  return values;
}

}  // namespace crackle::dynamics
