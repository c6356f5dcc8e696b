// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/realization.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::ensemble {

/// The largest share that a rank has when a number of ranks share one sample; the slowest sets the pace.
struct RankWork {
  int ranks = 1;
  std::int64_t tetrahedra = 0;  ///< computed by one rank, halo included
  std::int64_t ghosts = 0;      ///< nodes that one rank receives
  int neighbours = 0;           ///< ranks that it receives them from
};

/// Shares of a realization by the partition that a run would use.
/// @param halo as for geometry::split() [m]
RankWork largest_rank_work(const geometry::Realization& realization, int ranks, double halo = 0);

/// Tetrahedron updates per second of one core where none were measured: the force of one tetrahedron with its
/// share of the time step and the breaking check, under few breaks.
constexpr double updates_per_core_second(const input::Time& time) {
  if (time.engine == input::Engine::petsc) return 25e6;
  return time.precision == input::Precision::mixed ? 320e6 : 200e6;
}

/// Rate of a core in a group over that of a core that has a sample for itself.
inline constexpr double shared_rate_share = 0.95;

/// What the model reckons with; the defaults are cautious figures for a cluster of today.
/// `tools/benchmark` measures the first.
struct Machine {
  explicit Machine(const input::Time& time = {}) : Machine(updates_per_core_second(time)) {}
  /// @param updates_per_second measured on one core, see MeasuredCost
  explicit Machine(double updates_per_second)
      : updates_per_second(updates_per_second),
        shared_updates_per_second(shared_rate_share * updates_per_second) {}

  double updates_per_second;                ///< of one core that has a sample for itself
  double shared_updates_per_second;         ///< of one core in a group: waits for the others
  double mesh_updates_per_second = 0.85e6;  ///< tetrahedra of realizations that the master makes
  double root_updates_per_second = 0.5e6;   ///< tetrahedra that a root partitions, analyses and writes
  double latency = 3e-6;                    ///< of one message [s]
  double bandwidth = 5e9;                   ///< of one rank [byte/s]
};

/// Time of one force evaluation of a group, with its part of the step [s].
struct ForceTime {
  double computation = 0;
  double exchange = 0;  ///< of ghosts, as if nothing were hidden behind the computation
  double polls = 0;     ///< of sums over all ranks
  double total() const { return computation + exchange + polls; }
};
ForceTime force_time(const RankWork& work, const Machine& machine, input::Precision precision,
                     double forces_per_step);

/// How an ensemble runs with a number of ranks per sample.
struct GroupPlan {
  RankWork work;
  ForceTime force;
  std::int64_t groups = 0;
  double sample_seconds = 0;      ///< dynamic phases, what is static, and the root's own work
  double wall_seconds = 0;        ///< of the ensemble
  double efficiency = 0;          ///< work of one core for all samples over ranks times wall time
  bool waits_for_master = false;  ///< the master makes realizations more slowly than the groups use them up
};

/// Plans for 1, 2, 4, ... ranks per sample, as many as there are ranks besides the master and at most 64.
/// @param force_evaluations of one sample, all dynamic phases together
/// @param quasi_static time of one core for what is static [s]; ranks share it as they share a force
/// evaluation
std::vector<GroupPlan> make_plans(const geometry::Realization& realization,
                                  const input::Parameters& parameters, double force_evaluations,
                                  double quasi_static, const Machine& machine, std::int64_t ranks,
                                  std::int64_t samples);

/// The plan that ends first; with fewer ranks per sample where the difference is below 2 %.
const GroupPlan& recommended(std::span<const GroupPlan> plans);

}  // namespace crackle::ensemble
