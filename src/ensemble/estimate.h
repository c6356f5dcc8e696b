// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/first_break_prediction.h"
#include "dynamics/stable_step.h"
#include "ensemble/memory.h"
#include "ensemble/scaling.h"
#include "fracture/material_field.h"
#include "geometry/realization.h"
#include "input/study.h"

#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

namespace crackle::ensemble {

/// Default number of dynamic phases of a sample that starts quasi-statically; the last one runs for the full
/// duration. Samples of jobs/demo.toml have 1 to 6 (mean 3.3), those of jobs/paper/clock-from-zero.toml 1.5
/// on average.
inline constexpr int usual_phases = 2;

/// The smallest and the largest number of dynamic phases to expect.
struct PhaseRange {
  int least = usual_phases, most = usual_phases;
};

/// More than the usual number where a growing crack relieves the load, so that it arrests and starts again:
/// between moved grips, up to 10, and under a stress that changes with time, such as a thermal one, up to 60
/// (a disc shrunk into a ring: 34 to 57).
PhaseRange expected_phases(const input::Model& model);

/// Work of one dynamic phase of full duration.
struct PhaseWork {
  dynamics::TimeGrid grid{};
  std::int64_t force_evaluations = 0;
  std::int64_t exchanges = 0;   ///< of ghost displacements, between ranks that share the sample
  double bytes_per_ghost = 12;  ///< in an exchange
};

/// @param stable_step of the realization and the integrator [s]
/// @throws std::runtime_error naming time.step and the stable step when time.step exceeds the stable step
PhaseWork phase_work(const input::Time& time, double stable_step);

/// Expected dynamic phases and static solves of a sample.
struct SampleWork {
  int phases = 1;             ///< the last one runs for the full duration
  int phases_unbroken = 0;    ///< the same of a body that does not break
  double full_durations = 1;  ///< total dynamic time, in units of the full duration
  int solves = 0;             ///< equilibria after the first; 0 with start = "rest"
};

/// @param arrest_window see dynamics::arrest_window [s]
/// @param phases of a sample with start = "quasi-static"; ignored with start = "rest", which has one
SampleWork sample_work(const input::Time& time, double arrest_window, int phases = usual_phases);

/// Measured costs of the parts of a sample on this machine, in seconds of CPU time of one core, so that other
/// load on the machine matters little.
struct MeasuredCost {
  double setup = 0;        ///< operators, strengths, loads and coarse space of a sample [s]
  double first_solve = 0;  ///< equilibrium of the intact body [s]; 0 with start = "rest"
  double next_solve = 0;   ///< equilibrium after a break [s]; 0 if no load breaks the body
  /// Stresses and energy of the first equilibrium, with [[initial.stress]].
  std::optional<dynamics::StressState> initial = {};
  double share_at_start = 0;    ///< of stress in strength at time 0, the largest; for quasi-static loading
  fracture::BodyWaves waves{};  ///< see fracture::slowest_waves
  dynamics::FirstBreakPrediction outlook;  ///< for start = "rest": assumed to break
  double phase_start = 0;                  ///< overhead of a dynamic phase before its first step [s]
  double step = 0;           ///< one step of a dynamic phase: forces, breaking, energies and output [s]
  std::int64_t n_steps = 0;  ///< number of measured steps
  double agreements = 0;     ///< of all ranks that share a sample, per step
  double n_nodes = 0;        ///< of the mesh
};

/// The costs of the same body with so many times the tetrahedra, for the same ratio of time steps to
/// spacings.
MeasuredCost refined(MeasuredCost cost, double ratio);

/// The time loop could not be measured. This does not imply that a sample would fail: the measured body is
/// artificially weakened.
class NotMeasured : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Measures the costs on a realization: the equilibrium of the intact body, one break with the equilibrium
/// after it, and the time loop during fracture for the given time. Not collective.
/// @param seconds of the time loop
/// @throws NotMeasured when the motion is invalid; std::runtime_error for anything that makes a sample fail
///   before it moves: boundary conditions that select no nodes or hold too little, loads at time 0 above the
///   first break, no convergence to equilibrium
MeasuredCost measure_cost(const input::Model& model, int n_frames, const geometry::Realization& realization,
                          double seconds);

/// One-core time of a sample [s], without crack analysis and output.
struct SampleCost {
  double phase = 0;         ///< one dynamic phase of the full duration
  double dynamic = 0;       ///< all dynamic phases
  double quasi_static = 0;  ///< all equilibria
  double setup = 0;         ///< of the mechanics
  double mesh = 0;          ///< made by the master or the group's root
  GroupTraffic traffic{};   ///< on more than one rank
  double total() const { return dynamic + quasi_static + setup + mesh; }
};

/// @param mesh time to make one [s]
SampleCost sample_cost(const MeasuredCost& measured, const PhaseWork& phase, const SampleWork& work,
                       double mesh);

/// How an ensemble runs with a number of ranks per sample. Ranks that share a sample take the time of the
/// largest part, and of messages that nothing hides.
struct GroupPlan {
  int ranks = 1;                ///< per sample
  std::int64_t groups = 0;      ///< that compute samples at the same time
  std::int64_t tetrahedra = 0;  ///< of the largest part, those of other parts included
  double root_memory = 0;       ///< of the rank that divides the mesh [byte]
  double memory = 0;  ///< of each other rank of a group, shared mother points aside [byte]; 0 without any
  double division_seconds = 0;    ///< to divide the mesh; part of sample_seconds
  double message_seconds = 0;     ///< the same for messages
  double sample_seconds = 0;      ///< in a group, apart from its mesh
  double efficiency = 1;          ///< of a group: seconds of one rank over those of all
  double wall_seconds = 0;        ///< of the ensemble
  bool waits_for_master = false;  ///< the groups use meshes faster than the master makes them
};

/// Ranks per sample of the last plan: at most the ranks besides the master and 1024, and parts that do not
/// consist of surface.
int most_ranks_per_sample(double n_tetrahedra, std::int64_t ranks);

/// Plans for 1, 2, 4, ... ranks per sample.
/// @param parts of the mesh, for most_ranks_per_sample
std::vector<GroupPlan> make_plans(const PartSizes& parts, double n_nodes, const input::Study& study,
                                  const SampleCost& cost, std::int64_t ranks, const Network& network = {});

/// The fastest plan; differences below 2 % are resolved in favour of fewer ranks per sample.
const GroupPlan& recommended(std::span<const GroupPlan> plans);

/// Size of a sample file [byte], compressed; accurate to about 25 % for a sample that cracks.
double sample_file_size(int n_frames, double n_nodes, double n_tetrahedra);

/// Size of ensemble.h5 [byte].
double ensemble_file_size(const input::Study& study, double n_nodes);

}  // namespace crackle::ensemble
