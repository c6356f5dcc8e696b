// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/history.h"

#include "common/index.h"
#include "common/real.h"
#include "dynamics/machine_load.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"

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

/// Mean displacement of each condition's nodes at which it still acts, or of all of them if it has ended
/// everywhere. Collective.
std::vector<Vector> mean_displacements(const parallel::Communicator& group,
                                       std::span<const mechanics::ConditionNodes> conditions,
                                       std::span<const double> displacement) {
  std::vector<std::vector<double>> terms(3 * conditions.size());
  for (std::size_t k = 0; k < conditions.size(); ++k) {
    const auto& condition = conditions[k];
    for (std::size_t n = 0; n < condition.nodes.size(); ++n) {
      if (condition.acting_share > 0 && !condition.acts_at(n)) continue;
      for (int c = 0; c < 3; ++c)
        terms[3 * k + index(c)].push_back(condition.share[n] * displacement[index(condition.nodes[n], c)]);
    }
  }
  const auto sums = parallel::exact_sums(group, terms);
  std::vector<Vector> means(conditions.size());
  for (std::size_t k = 0; k < conditions.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c)
      means[k][c] = sums[3 * k + c] / (conditions[k].acting_share > 0 ? conditions[k].acting_share : 1);
  return means;
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

void HistoryRecorder::record_equilibrium(double load_time, const LoadState& loads,
                                         const parallel::NodeField& displacement) {
  HistoryRow row;
  row.load_time = load_time;
  row.energy = account_->row(0, {.strain = loads.stored});
  add(std::move(row), loads, displacement, nullptr);
}

void HistoryRecorder::record_motion(std::int32_t phase, double load_time, const EnergyRow& energy,
                                    const parallel::NodeField& displacement,
                                    const parallel::NodeField& velocity, const LoadState& loads,
                                    bool is_output) {
  HistoryRow row;
  row.is_output = is_output;
  row.load_time = load_time + energy.time;
  row.phase = phase;
  row.energy = energy;
  add(std::move(row), loads, displacement, &velocity);
}

std::vector<HistoryRow> HistoryRecorder::rows_of_phase(std::int32_t phase) const {
  std::vector<HistoryRow> rows;
  std::ranges::copy_if(rows_, std::back_inserter(rows),
                       [&](const HistoryRow& row) { return row.phase == phase; });
  return rows;
}

void HistoryRecorder::add(HistoryRow row, const LoadState& state, const parallel::NodeField& displacement,
                          const parallel::NodeField* velocity) {
  const Load load = machine_load(*loads_, state);
  row.load = load.force;
  row.load_displacement = load.displacement;
  for (const ConditionState& condition : state.conditions) row.force.push_back(condition.force());
  row.records = state.records;
  row.tools = state.tools;
  row.displacement = mean_displacements(*group_, loads_->conditions, displacement.local());
  row.probes = probes_.read(displacement, velocity);
  rows_.push_back(std::move(row));
}

}  // namespace crackle::dynamics
