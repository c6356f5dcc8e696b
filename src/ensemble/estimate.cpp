// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/estimate.h"

#include "dynamics/integrator.h"
#include "dynamics/sample_run.h"

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

constexpr int most_ranks = 1024;
/// Tetrahedra of a part, which computes as many of other parts (tests/benchmark/README.md).
constexpr double least_part = 2000;

// The static solver, from the plates of tests/benchmark/README.md.
constexpr double forces_per_iteration = 8;  // in time, with the start of a solution
constexpr double agreements_per_iteration = 5;
// Its coarse problem, which every rank solves: cells have a number of nodes, in large bodies more.
constexpr double nodes_per_cell = 175, most_cells = 2700;
constexpr double of_cell_pair = 2.4e-9;  // [s]

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
  const auto drifts = std::ranges::count(dynamics::splitting(time.integrator).even,
                                         dynamics::Stage::Kind::drift, &dynamics::Stage::kind);
  return {grid, static_cast<std::int64_t>(std::ceil(forces_per_step * static_cast<double>(grid.n_steps))),
          drifts * grid.n_steps, time.precision == input::Precision::mixed ? 12.0 : 24.0};
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

MeasuredCost refined(MeasuredCost cost, double ratio) {
  // Equilibria take more iterations, as the ratio of lengths.
  const double of_solves = std::pow(ratio, 4.0 / 3);
  for (double* const linear : {&cost.setup, &cost.phase_start, &cost.step, &cost.n_nodes}) *linear *= ratio;
  for (double* const solve : {&cost.first_solve, &cost.next_solve}) *solve *= of_solves;
  return cost;
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

  const auto n_steps = static_cast<double>(phase.grid.n_steps);
  const double durations = measured.outlook.breaks ? work.full_durations : work.phases_unbroken;
  const double force =
      measured.step * n_steps / static_cast<double>(std::max<std::int64_t>(1, phase.force_evaluations));
  const double iterations = force > 0 ? cost.quasi_static / (forces_per_iteration * force) : 0;
  const double cells = std::min(most_cells, measured.n_nodes / nodes_per_cell);
  cost.traffic.exchanges = durations * static_cast<double>(phase.exchanges) + iterations;
  cost.traffic.bytes_per_ghost = phase.bytes_per_ghost;
  cost.traffic.agreements = durations * n_steps * measured.agreements + agreements_per_iteration * iterations;
  cost.traffic.repeated = std::min(cost.quasi_static, iterations * of_cell_pair * cells * cells);
  return cost;
}

int most_ranks_per_sample(double n_tetrahedra, std::int64_t ranks) {
  const double by_parts = std::max(1.0, n_tetrahedra / least_part);
  return static_cast<int>(std::min({by_parts, static_cast<double>(std::max<std::int64_t>(1, ranks - 1)),
                                    static_cast<double>(most_ranks)}));
}

std::vector<GroupPlan> make_plans(const PartSizes& parts, double n_nodes, const input::Study& study,
                                  const SampleCost& cost, std::int64_t ranks, const Network& network) {
  const double n_tetrahedra = parts.n_tetrahedra();
  const std::int64_t samples = study.ensemble.samples;
  const double alone = cost.total() - cost.mesh;
  std::vector<GroupPlan> plans;
  for (int q = 1; q <= most_ranks_per_sample(n_tetrahedra, ranks); q *= 2) {
    const LargestPart part = parts.of(q);
    GroupPlan plan{.ranks = q,
                   .groups = std::max<std::int64_t>(1, (ranks - 1) / q),
                   .tetrahedra = std::llround(part.tetrahedra)};
    const auto memory =
        memory_demand(study, n_nodes, n_tetrahedra,
                      make_group_layout(static_cast<int>(1 + plan.groups * q), q), part.tetrahedra);
    plan.root_memory = memory.root;
    plan.memory = q > 1 ? memory.member : 0;
    plan.division_seconds = part.seconds;
    plan.message_seconds = cost.traffic.seconds(q, part, network);
    const double repeated = q > 1 ? cost.traffic.repeated : 0;
    plan.sample_seconds = (alone - repeated) * part.tetrahedra / n_tetrahedra + repeated +
                          plan.message_seconds + plan.division_seconds;
    plan.efficiency = alone / (q * plan.sample_seconds);
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
