// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/estimate.h"

#include "dynamics/integrator.h"
#include "dynamics/sample_run.h"
#include "geometry/partition.h"
#include "geometry/subdomain.h"

#include <algorithm>
#include <cmath>

namespace crackle::ensemble {

namespace {

// From samples of jobs/demo.toml and jobs/paper/clock-from-zero.toml, per dynamic phase except the last:
// cracks run for this many durations before the arrest window begins, and this many tetrahedra break
// quasi-statically.
constexpr double running_durations = 0.4;
constexpr double static_breaks_per_phase = 1.5;

constexpr int phases_between_moved_grips = 10, phases_of_changing_stress = 60;

constexpr int most_ranks_per_sample = 64;
/// Tetrahedra of a part, of which exchange takes some 30 % of the time on one node; 6 to 10 % of 10,000
/// (tests/benchmark/README.md).
constexpr std::int64_t least_part = 2000;

/// Broken tetrahedra of a sample divided by (tetrahedra of the mesh)^(2/3), since cracks are surfaces.
constexpr double breaks_per_section = 1.2;

// Bytes in a sample file after compression, from files of jobs/demo.toml and jobs/paper/clock-from-zero.toml.
constexpr double of_frame_node = 17;
constexpr double of_node = 20;
constexpr double of_tetrahedron = 4.7;  // boundary triangles included
constexpr double of_break = 210;        // crack surface included
constexpr double of_structure = 120e3;  // groups, names, energies
// Bytes in ensemble.h5.
constexpr double of_mother_point = 33;
constexpr double of_row = 200;
constexpr double of_crossing = 36;

}  // namespace

PhaseWork phase_work(const input::Time& time, double stable_step) {
  const dynamics::TimeGrid grid = dynamics::choose_time_grid(time, stable_step);
  const double forces_per_step = dynamics::splitting(time.integrator).forces_per_step;
  return {grid, static_cast<std::int64_t>(std::ceil(forces_per_step * static_cast<double>(grid.n_steps)))};
}

PhaseRange expected_phases(const input::Model& model) {
  if (model.time.start == input::Start::rest) return {1, 1};
  const auto changes = [](const input::InitialStress& stress) {
    return std::ranges::any_of(stress.history,
                               [&](const auto& entry) { return entry.second != stress.history[0].second; });
  };
  const auto moves = [](const input::Boundary& condition) {
    return input::prescribes_motion(condition.kind) &&
           (condition.value != Vector{} || condition.rate != Vector{});
  };
  if (std::ranges::any_of(model.initial_stresses, changes)) return {usual_phases, phases_of_changing_stress};
  if (std::ranges::any_of(model.boundaries, moves)) return {usual_phases, phases_between_moved_grips};
  return {};
}

SampleWork sample_work(const input::Time& time, double arrest_window, int phases) {
  if (time.start == input::Start::rest) return {};
  const double arrested =
      std::min<double>(dynamics::max_phase_durations, running_durations + arrest_window / time.duration);
  // One equilibrium after each quasi-static break and one after each arrest.
  const double solves = static_breaks_per_phase * phases + (phases - 1);
  return {phases, time.start == input::Start::equilibrium ? 1 : 0, 1 + (phases - 1) * arrested,
          static_cast<int>(std::lround(solves))};
}

SampleCost sample_cost(const MeasuredCost& measured, const PhaseWork& phase, const SampleWork& work,
                       double mesh) {
  SampleCost cost;
  cost.phase = measured.phase_start + measured.step * static_cast<double>(phase.grid.n_steps);
  cost.dynamic = measured.outlook.breaks
                     ? work.phases * measured.phase_start +
                           work.full_durations * measured.step * static_cast<double>(phase.grid.n_steps)
                     : work.phases_unbroken * cost.phase;
  cost.quasi_static = measured.first_solve + work.solves * measured.next_solve;
  cost.setup = measured.setup;
  cost.mesh = mesh;
  return cost;
}

std::vector<GroupPlan> make_plans(const geometry::Realization& realization, const input::Study& study,
                                  const SampleCost& cost, std::int64_t ranks) {
  const auto n_tetrahedra = static_cast<std::int64_t>(realization.tetrahedra.size());
  const std::int64_t samples = study.ensemble.samples;
  std::vector<GroupPlan> plans;
  for (int q = 1; q <= std::clamp<std::int64_t>(ranks - 1, 1, most_ranks_per_sample); q *= 2) {
    if (q > 1 && n_tetrahedra / q < least_part) break;
    GroupPlan plan{.ranks = q, .groups = std::max<std::int64_t>(1, (ranks - 1) / q)};
    for (const auto& part :
         geometry::split(realization, geometry::partition(realization, q), study.fracture.length))
      plan.tetrahedra = std::max<std::int64_t>(plan.tetrahedra, part.n_tetrahedra());
    plan.sample_seconds =
        (cost.total() - cost.mesh) * static_cast<double>(plan.tetrahedra) / static_cast<double>(n_tetrahedra);
    const auto rounds = static_cast<double>((samples + plan.groups - 1) / plan.groups);
    const double computing = rounds * plan.sample_seconds + cost.mesh;
    const double meshing = static_cast<double>(samples) * cost.mesh + plan.sample_seconds;
    const double by_master = std::max(computing, meshing);
    const double by_groups = rounds * (plan.sample_seconds + cost.mesh);
    const auto makers = study.ensemble.meshes;
    plan.waits_for_master = makers == input::MeshMakers::master && meshing > computing;
    plan.wall_seconds = makers == input::MeshMakers::master   ? by_master
                        : makers == input::MeshMakers::groups ? by_groups
                                                              : std::min(by_master, by_groups);
    plans.push_back(plan);
  }
  return plans;
}

const GroupPlan& recommended(std::span<const GroupPlan> plans) {
  const double enough = 1.02 * std::ranges::min(plans, {}, &GroupPlan::wall_seconds).wall_seconds;
  return *std::ranges::find_if(plans, [&](const GroupPlan& plan) { return plan.wall_seconds <= enough; });
}

double sample_file_size(int n_frames, double n_nodes, double n_tetrahedra) {
  const double n_breaks = breaks_per_section * std::pow(n_tetrahedra, 2.0 / 3);
  return of_structure + n_nodes * (of_node + of_frame_node * n_frames) + n_tetrahedra * of_tetrahedron +
         n_breaks * of_break;
}

double ensemble_file_size(const input::Study& study, double n_nodes) {
  const auto n_crossings = static_cast<double>(geometry::n_crack_starts(study) * study.sections.size());
  const double n_mother_points = study.mesh.base == input::Base::shared ? n_nodes : 0;
  return of_structure + of_mother_point * n_mother_points +
         study.ensemble.samples * (of_row + of_crossing * n_crossings);
}

}  // namespace crackle::ensemble
