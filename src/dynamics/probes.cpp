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
    if (subdomain.owned[index(t)] == 0) continue;
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
    parallel::check_peers(group);
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
  std::vector<std::vector<double>> terms;  // of the components of each place
  const auto add_at_nodes = [&](const Place& place, std::span<const double> field) {
    for (std::size_t c = 0; c < 3; ++c) {
      auto& sum = terms.emplace_back();
      for (const auto& [node, weight] : place.nodes) sum.push_back(weight * field[3 * index(node) + c]);
    }
  };
  const auto u = displacement.local();
  for (const Place& place : places_) {
    add_at_nodes(place, u);
    if (velocity != nullptr) add_at_nodes(place, velocity->owned());
    const std::size_t first = terms.size();
    terms.resize(first + std::tuple_size_v<mechanics::Symmetric>);
    for (const auto& [t, weight] : place.tetrahedra) {
      const auto stress = body_->residual_stiffness().stress(t, body_->strain(t, u));
      for (std::size_t c = 0; c < stress.size(); ++c) terms[first + c].push_back(weight * stress[c]);
    }
  }
  const auto sums = parallel::exact_sums(*group_, terms);
  auto next = sums.begin();
  std::vector<ProbeValue> values(places_.size());
  for (ProbeValue& value : values) {
    for (double& component : value.displacement) component = *next++;
    if (velocity != nullptr)
      for (double& component : value.velocity) component = *next++;
    for (double& component : value.stress) component = *next++;
  }
  return values;
}

}  // namespace crackle::dynamics
