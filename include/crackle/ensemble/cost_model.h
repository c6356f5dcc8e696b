// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/realization.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::ensemble {

/// The largest load on any rank when several ranks share one sample; the slowest rank sets the pace.
struct RankWork {
  int ranks = 1;
  std::int64_t tetrahedra = 0;  ///< computed by one rank, halo included
  std::int64_t ghosts = 0;      ///< nodes received by one rank
  int neighbours = 0;           ///< ranks it receives from
};

/// Largest shares under the partition that a run would use.
/// @param halo as for geometry::split() [m]
RankWork largest_rank_work(const geometry::Realization& realization, int ranks, double halo = 0);

/// Tetrahedron updates per second on one core, used when no measurement is available. An update is the force
/// of one tetrahedron with its share of the time step and of the fracture check, while few tetrahedra break.
constexpr double updates_per_core_second(const input::Time& time) {
  if (time.engine == input::Engine::petsc) return 25e6;
  return time.precision == input::Precision::mixed ? 320e6 : 200e6;
}

/// Rate of a core in a group relative to that of a core with a sample of its own.
inline constexpr double shared_rate_share = 0.95;

/// Machine parameters of the cost model; the defaults are cautious figures for a current cluster.
/// `tools/benchmark` measures the first.
struct Machine {
  explicit Machine(const input::Time& time = {}) : Machine(updates_per_core_second(time)) {}
  /// @param updates_per_second measured on one core, see MeasuredCost
  explicit Machine(double updates_per_second)
      : updates_per_second(updates_per_second),
        shared_updates_per_second(shared_rate_share * updates_per_second) {}

  double updates_per_second;                ///< of a core with a sample of its own
  double shared_updates_per_second;         ///< of a core in a group, which waits for the others
  double mesh_updates_per_second = 0.85e6;  ///< tetrahedra meshed by the master
  double root_updates_per_second = 0.5e6;   ///< tetrahedra partitioned, analysed and written by a root
  double latency = 3e-6;                    ///< of one message [s]
  double bandwidth = 5e9;                   ///< of one rank [byte/s]
};

/// Time of one force evaluation in a group, with its part of the time step [s].
struct ForceTime {
  double computation = 0;
  double exchange = 0;  ///< of ghosts, assuming no overlap with computation
  double polls = 0;     ///< global reductions of polls
  double total() const { return computation + exchange + polls; }
};
ForceTime force_time(const RankWork& work, const Machine& machine, input::Precision precision,
                     double forces_per_step);

/// How an ensemble runs with a number of ranks per sample.
struct GroupPlan {
  RankWork work;
  ForceTime force;
  std::int64_t groups = 0;
  double sample_seconds = 0;      ///< dynamic phases, static solves and the root's serial work
  double wall_seconds = 0;        ///< of the ensemble
  double efficiency = 0;          ///< one-core work for all samples / (ranks * wall time)
  bool waits_for_master = false;  ///< the groups use realizations faster than the master makes them
};

/// Plans for 1, 2, 4, ... ranks per sample, up to the number of ranks besides the master and at most 64.
/// @param force_evaluations of one sample, over all dynamic phases
/// @param quasi_static one-core time of the static solves [s]; assumed to scale over ranks like a force
///   evaluation
std::vector<GroupPlan> make_plans(const geometry::Realization& realization,
                                  const input::Parameters& parameters, double force_evaluations,
                                  double quasi_static, const Machine& machine, std::int64_t ranks,
                                  std::int64_t samples);

/// The fastest plan; differences below 2 % are resolved in favour of fewer ranks per sample.
const GroupPlan& recommended(std::span<const GroupPlan> plans);

}  // namespace crackle::ensemble
