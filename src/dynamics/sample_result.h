// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "common/vector.h"
#include "dynamics/mass_scaling.h"
#include "fracture/break_record.h"
#include "mechanics/tensor.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace crackle::dynamics {

/// The energy balance at one time of the last dynamic phase [J]: external = kinetic + strain + released +
/// dissipated, each counted from the unloaded body. `dissipated` includes the residual motion of arrested
/// phases and quasi-static breaks, damping, bulk viscosity and absorbing faces.
struct EnergyRow {
  double time;  ///< since the start of the phase [s]
  double kinetic;
  double strain;
  double external;
  double released;
  double dissipated;
  std::int64_t broken;  ///< tetrahedra broken so far
  bool operator==(const EnergyRow&) const = default;
};

/// Values at a probe at one moment.
struct ProbeValue {
  Vector displacement{};          ///< [m]
  Vector velocity{};              ///< [m/s]; 0 in quasi-static loading
  mechanics::Symmetric stress{};  ///< xx, yy, zz, yz, xz, xy: stress carried by the material [Pa]
  bool operator==(const ProbeValue&) const = default;
};

/// A quantity that a contribution to the motion records at one moment.
struct Record {
  std::string name, unit, meaning;  ///< the name is unique among a sample's
  double value = 0;
  bool operator==(const Record&) const = default;
};

/// A rigid tool at one moment.
struct ToolState {
  Vector position{};      ///< of the input's point `at` [m]
  Vector displacement{};  ///< since the start [m]
  Vector velocity{};      ///< [m/s]
  /// Quaternion (w, x, y, z) that turns the tool from its place at the start.
  std::array<double, 4> orientation{1, 0, 0, 0};
  Vector angular_velocity{};  ///< [rad/s]
  Vector reaction{};          ///< force on the body [N]
  double friction_work = 0;   ///< lost by friction, in dynamic phases since their start [J]
  bool operator==(const ToolState&) const = default;
};

/// One entry of a sample's history: an equilibrium of quasi-static loading, or a moment of a dynamic phase.
struct HistoryRow {
  double load_time = 0;               ///< of the load curves [s]
  std::int32_t phase = 0;             ///< number of the dynamic phase, from 1; 0 in quasi-static loading
  EnergyRow energy{};                 ///< its time counts from the start of the dynamic phase
  double load = 0;                    ///< of the testing machine (machine_load.h) [N]
  double load_displacement = 0;       ///< likewise [m]
  std::vector<Vector> force;          ///< exerted on the body by each boundary condition [N]
  std::vector<Vector> displacement;   ///< mean of each condition's nodes [m]
  std::vector<ProbeValue> probes;     ///< in the order of the input
  std::vector<Record> records = {};   ///< of terms (term.h); the same quantities in every row
  std::vector<ToolState> tools = {};  ///< in the order of the input
  bool is_output = true;              ///< false: measured for the machine's results only
  bool operator==(const HistoryRow&) const = default;
};

/// A sample's results as a testing machine would record them (machine_load.h).
struct LoadResults {
  double peak_load = not_a_number;             ///< [N]
  double displacement_at_peak = not_a_number;  ///< [m]
  double work_of_fracture = not_a_number;      ///< [J]
  bool end_at_peak = false;                    ///< the last load is the peak, which so may not be the last
};

/// A snapshot of the fields during the last dynamic phase; on the group's root only.
struct Frame {
  double time;                      ///< since the start of the phase [s]
  std::vector<float> displacement;  ///< n_nodes x 3, in the realization's numbering [m]
  std::vector<float> velocity;      ///< n_nodes x 3 [m/s]
  std::int64_t broken;              ///< the first `broken` entries of SampleResult::breaks are open
};

/// A piece of the body whose nodes edges that carry load connect (fracture::piece_labels), or several nodes
/// that nothing connects. Its mass is that of its nodes, by which it moves.
struct Fragment {
  std::int64_t first_node = -1;  ///< smallest node number
  std::int64_t n_nodes = 0;
  double mass = 0;         ///< [kg]
  double volume = 0;       ///< [m^3]
  Vector center{};         ///< centre of mass where it is [m]
  Vector velocity{};       ///< mean, weighted with the mass [m/s]
  double kinetic = 0;      ///< kinetic energy of its nodes [J]
  Vector extent{};         ///< of its nodes in the unloaded body, along x, y, z [m]
  bool is_frozen = false;  ///< at rest since its numbers would have left their range
  /// Kinetic energy of the mean motion; the rest is rotation and vibration [J].
  double kinetic_of_mean() const { return 0.5 * mass * dot(velocity, velocity); }
};

/// The pieces of a body at one moment; single nodes are dust. On a group's root.
struct Fragments {
  std::vector<Fragment> pieces;  ///< of two nodes or more, by mass, the largest first, then by first_node
  Fragment dust;                 ///< all single nodes together
  double mass = 0;               ///< of the body [kg]
  std::vector<std::int32_t> of_node;  ///< piece of each node of the realization; -1: dust
};

/// The same in numbers.
struct FragmentCount {
  double time = 0;           ///< since the start of the phase [s]
  std::int64_t number = 0;   ///< of pieces of two nodes or more
  double largest_mass = 0;   ///< [kg]
  double second_mass = 0;    ///< of the second largest; 0 if there is one only [kg]
  std::int64_t dust = 0;     ///< number of single nodes
  double dust_mass = 0;      ///< [kg]
  std::int64_t frozen = 0;   ///< number of frozen pieces, single nodes too
  double frozen_mass = 0;    ///< [kg]
  double frozen_energy = 0;  ///< kinetic energy taken from them [J]
};

/// How a sample ended; separated as defined by is_separated.
enum class Outcome {
  unbroken = 0,   ///< nothing broke
  arrested = 1,   ///< breaking stopped and the load cannot grow further
  separated = 2,  ///< the body separated
  running = 3,    ///< in one piece at the end of the duration
  undecided = 4,  ///< in one piece, but still breaking after max_phase_durations durations
};

/// A dynamic phase after quasi-static loading in which breaking continues beyond its duration is extended to
/// at most this many durations, to see whether it arrests: if so, loading continues, and it was not the last
/// phase.
inline constexpr int max_phase_durations = 3;

/// Work counts of a sample; equal on every machine.
struct SampleCounts {
  std::int64_t quasi_static_breaks = 0;
  std::int64_t static_solves = 0;
  std::int64_t solver_iterations = 0;
  std::int64_t dynamic_phases = 0;
  std::int64_t steps = 0;  ///< of all dynamic phases
  std::int64_t force_evaluations = 0;
  std::int64_t range_restarts =
      0;  ///< 1: mixed precision was out of range and everything was recomputed in double
};

/// Communication within a group during dynamic phases.
struct ExchangeCost {
  std::int64_t n_exchanges = 0;         ///< of ghost displacements
  std::int64_t bytes_per_exchange = 0;  ///< received by this rank
  double seconds = 0;                   ///< spent beginning and ending them [s]

  ExchangeCost& operator+=(const ExchangeCost& phase) {
    n_exchanges += phase.n_exchanges;
    bytes_per_exchange = phase.bytes_per_exchange;
    seconds += phase.seconds;
    return *this;
  }
};

/// Wall-clock times and communication; differ between runs and numbers of ranks.
struct SampleTimings {
  double mesh = 0;
  double setup = 0;
  double quasi_static = 0;
  double dynamic = 0;
  double element_updates_per_second = 0;  ///< tetrahedra x force evaluations / dynamic time, of the group
  ExchangeCost exchange_cost{};
};

/// Result of the mechanics of one sample. Complete on the group's root; elsewhere breaks, bridge releases,
/// frames and fragments are empty.
struct SampleResult {
  static constexpr double none = not_a_number;

  bool suspended = false;  ///< stopped part-way on request; the rest is undefined
  Outcome outcome = Outcome::unbroken;
  std::string note;  ///< remarks about the end; usually empty
  /// Load time at the first break [s] and the machine's load then [N]; NaN if nothing broke.
  double first_break_time = none;
  double first_break_load = none;
  /// Load time at the start of the last dynamic phase [s] and the machine's load then [N]; NaN if no dynamic
  /// phase followed quasi-static loading.
  double onset_time = none;
  double onset_force = none;
  double phase_start = none;  ///< load time at the start of the last dynamic phase [s], 0 with start = "rest"
  /// Time since phase_start from which no load can be transferred between conditions [s]; NaN if this did not
  /// happen in the last dynamic phase.
  double separated_at = none;
  bool load_is_reaction = false;  ///< the machine's load is, at least in part, a reaction
  double time_step = 0;           ///< used in the run [s]
  double stable_step = 0;         ///< of the integrator on the intact body [s]
  std::optional<MassScaling> mass_scaling = {};
  double wave_transit = none;  ///< see dynamics::wave_transit [s]
  double energy_error = 0;     ///< largest imbalance over the outputs, relative to the work done
  double equilibrium_residual =
      none;  ///< largest residual of the static solves, relative to the load; NaN without any
  std::vector<fracture::Break> breaks;  ///< sorted by time, then by tetrahedron number
  std::vector<fracture::BridgeRelease>
      bridge_releases;  ///< in the same order; empty with release by elements
  std::vector<fracture::StiffnessReduction>
      stiffness_reductions;  ///< in the same order; empty without softening
  std::vector<EnergyRow> energy;
  std::vector<HistoryRow> history;  ///< of the whole sample, in order
  LoadResults loads;                ///< whatever the interval of the history
  std::vector<Frame> frames;
  Fragments fragments;                          ///< at the end; empty after a failure
  std::vector<FragmentCount> fragment_history;  ///< of the last dynamic phase
  SampleCounts counts;
  SampleTimings timings;
};

std::string to_string(Outcome outcome);

/// Drops breaks, energy rows and history rows after the counted time of the last dynamic phase: they only
/// served to show that it was the last one. Everything counts if loading continued after it.
/// @param end_time since the start of the last phase [s]
void truncate_results(SampleResult& result, double end_time);

}  // namespace crackle::dynamics
