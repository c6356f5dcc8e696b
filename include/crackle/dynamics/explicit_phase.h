// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/energy_account.h"
#include "crackle/dynamics/integrator.h"
#include "crackle/dynamics/sample_result.h"
#include "crackle/dynamics/stable_step.h"
#include "crackle/fracture/breakable_body.h"
#include "crackle/fracture/tuler_butcher.h"
#include "crackle/mechanics/boundary_loads.h"
#include "crackle/parallel/communicator.h"
#include "crackle/parallel/node_field.h"

#include <functional>
#include <optional>
#include <vector>

namespace crackle::dynamics {

struct PhaseOptions {
  TimeGrid grid{};
  std::optional<double> arrest_window;  ///< a phase without a break for this long ends [s]; empty: never
  int n_frames = 0;                     ///< frames over the whole duration, first and last included
  int n_energy_rows = 200;              ///< about this many rows of the energy account
  std::function<void(const EnergyRow& row)> on_row;  ///< called for each of them, on every rank; may be empty
};

struct PhaseResult {
  bool arrested = false;
  double time = 0;           ///< at which the phase ended, since its start [s]
  double kinetic = 0;        ///< energy then [J]
  double external_work = 0;  ///< of the phase [J]
  std::int64_t n_steps = 0;
  std::int64_t n_forces = 0;
  std::vector<EnergyRow> energy;
  std::vector<Frame> frames;  ///< root only
};

/// The state of a moving body.
struct MotionState {
  parallel::NodeField displacement;  ///< [m]
  parallel::NodeField velocity;      ///< [m/s]
};

/// Explicit dynamics with breaking: the splitting's stages, at the end of every step the breaking check, then
/// outputs. On return `state` is the last one. Collective.
/// @param load_time time of the load programs at the phase's start [s]
PhaseResult run_explicit_phase(const parallel::Communicator& group, fracture::BreakableBody& body,
                               const mechanics::BoundaryLoads& loads, fracture::TulerButcher& criterion,
                               const Splitting& splitting, const EnergyAccount& account, double load_time,
                               const PhaseOptions& options, MotionState& state);

/// The tetrahedra that break at the end of a step: adds the step's impulse to every tetrahedron above the
/// threshold. Local; ghosts of `displacement` must be up to date.
std::vector<std::int32_t> breaking_tetrahedra(const fracture::BreakableBody& body,
                                              std::span<const double> displacement, double time_step,
                                              fracture::TulerButcher& criterion);

}  // namespace crackle::dynamics
