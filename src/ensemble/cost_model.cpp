// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/cost_model.h"

#include "crackle/common/index.h"
#include "crackle/dynamics/explicit_phase.h"
#include "crackle/dynamics/integrator.h"
#include "crackle/ensemble/base_points.h"
#include "crackle/geometry/partition.h"
#include "crackle/geometry/subdomain.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>

namespace crackle::ensemble {

namespace {

/// Global reductions per poll of a dynamic phase.
constexpr double sums_per_poll = 3;
constexpr int most_ranks_per_sample = 64;

}  // namespace

RankWork largest_rank_work(const geometry::Realization& realization, int ranks, double halo) {
  RankWork work{ranks, static_cast<std::int64_t>(realization.tetrahedra.size()), 0, 0};
  if (ranks == 1) return work;
  work.tetrahedra = 0;
  const auto partition = geometry::partition(realization, ranks);
  for (const auto& part : geometry::split(realization, partition, halo)) {
    work.tetrahedra = std::max<std::int64_t>(work.tetrahedra, part.n_tetrahedra());
    work.ghosts = std::max<std::int64_t>(work.ghosts, part.n_local() - part.layout.n_owned);
    std::set<std::int32_t> owners;
    for (auto i = static_cast<std::size_t>(part.layout.n_owned); i < part.nodes.size(); ++i)
      owners.insert(partition.node_part[index(part.layout.number[i])]);
    work.neighbours = std::max(work.neighbours, static_cast<int>(owners.size()));
  }
  return work;
}

ForceTime force_time(const RankWork& work, const Machine& machine, input::Precision precision,
                     double forces_per_step) {
  ForceTime time;
  const auto n = static_cast<double>(work.tetrahedra);
  if (work.ranks == 1) {
    time.computation = n / machine.updates_per_second;
    return time;
  }
  const double bytes_per_ghost = precision == input::Precision::mixed ? 12 : 24;
  time.computation = n / machine.shared_updates_per_second;
  time.exchange = work.neighbours * machine.latency +
                  static_cast<double>(work.ghosts) * bytes_per_ghost / machine.bandwidth;
  time.polls =
      sums_per_poll * std::log2(work.ranks) * machine.latency / dynamics::steps_per_poll / forces_per_step;
  return time;
}

std::vector<GroupPlan> make_plans(const geometry::Realization& realization,
                                  const input::Parameters& parameters, double force_evaluations,
                                  double quasi_static, const Machine& machine, std::int64_t ranks,
                                  std::int64_t samples) {
  const auto precision = parameters.time.precision;
  const double forces_per_step = dynamics::splitting(parameters.time.integrator).forces_per_step;
  double mesh_seconds = static_cast<double>(realization.tetrahedra.size()) / machine.mesh_updates_per_second;
  if (parameters.mesh.base == input::Base::own)
    mesh_seconds += placing_seconds(static_cast<double>(realization.nodes.size()));
  const double root_seconds =
      static_cast<double>(realization.tetrahedra.size()) / machine.root_updates_per_second;
  std::vector<GroupPlan> plans;
  double alone = 0;
  double force_alone = 0;
  for (int q = 1; q <= most_ranks_per_sample && q <= std::max<std::int64_t>(1, ranks - 1); q *= 2) {
    GroupPlan plan;
    plan.work = largest_rank_work(realization, q, parameters.fracture.length);
    plan.force = force_time(plan.work, machine, precision, forces_per_step);
    plan.groups = std::max<std::int64_t>(1, (ranks - 1) / q);
    if (q == 1) force_alone = plan.force.total();
    plan.sample_seconds =
        (force_evaluations + quasi_static / force_alone) * plan.force.total() + root_seconds;
    if (q == 1) alone = plan.sample_seconds;
    const auto rounds = (samples + plan.groups - 1) / plan.groups;
    const double computing = static_cast<double>(rounds) * plan.sample_seconds + mesh_seconds;
    const double meshing = static_cast<double>(samples) * mesh_seconds + plan.sample_seconds;
    const double fed_by_master = std::max(computing, meshing);
    const double fed_by_groups = static_cast<double>(rounds) * (plan.sample_seconds + mesh_seconds);
    const auto makers = parameters.ensemble.meshes;
    plan.waits_for_master = makers == input::MeshMakers::master && meshing > computing;
    plan.wall_seconds = makers == input::MeshMakers::master   ? fed_by_master
                        : makers == input::MeshMakers::groups ? fed_by_groups
                                                              : std::min(fed_by_master, fed_by_groups);
    plan.efficiency = static_cast<double>(samples) * alone / (static_cast<double>(ranks) * plan.wall_seconds);
    plans.push_back(plan);
  }
  return plans;
}

const GroupPlan& recommended(std::span<const GroupPlan> plans) {
  const auto fastest = std::ranges::min_element(plans, {}, &GroupPlan::wall_seconds);
  const double enough = 1.02 * fastest->wall_seconds;
  return *std::ranges::find_if(plans, [&](const GroupPlan& plan) { return plan.wall_seconds <= enough; });
}

}  // namespace crackle::ensemble
