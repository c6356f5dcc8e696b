// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/moving_body.h"

#include <span>
#include <vector>

namespace crackle::dynamics {

/// The work of the loads as the splitting itself counts it.
///
/// With a splitting the energy that stays constant to its order is T + U - F(t).u + the sum over kicks of
/// F'(t).u dt; this is that sum's external part, so the account closes to the integrator's order whatever
/// the programs are. Prescribed motions add the work of the internal forces on them, and their kinetic
/// energy.
class ExternalWork {
public:
  /// @param state with the prescribed values at `time` set
  ExternalWork(const MotionContext& context, double time, const MotionState& state,
               std::span<const double> driven_kinetic_before);

  /// A kick with pattern k displaces nothing, but its amplitude changes: node n of the pattern has
  /// displacement u.
  void add_rate(std::size_t k, std::size_t n, double duration_times_slope, double u) {
    const auto& pattern = context_.loads->forces[k];
    if (pattern.does_work_at(n)) rate_work_[k][n] += duration_times_slope * pattern.weight[n] * u;
  }
  /// Node n of motion m moves on with `velocity` against the internal force f.
  void add_reaction(std::size_t m, std::size_t n, double duration_times_velocity, double f) {
    reaction_work_[m][n] += duration_times_velocity * f;
  }

  /// The loads are about to end at these nodes: they keep the work that they have done.
  void end_loads(double time, const mechanics::NodesOfConditions& nodes, const MotionState& state);

  /// Puts the sums so far into the checkpoint, gathered on the root. Collective.
  void save(MotionCheckpoint& checkpoint) const;
  /// Takes them out again. Local.
  void restore(const MotionCheckpoint& checkpoint);

  /// Since the start [J]. Collective.
  double value(double time, const MotionState& state) const;

private:
  std::vector<double> load_potential(double time, const MotionState& state) const;

  MotionContext context_;
  std::vector<std::vector<double>> rate_work_;      // for each pattern and node
  std::vector<std::vector<double>> reaction_work_;  // for each motion and node
  std::vector<double> start_;
};

/// Values at the nodes of conditions, one list for each, as tables gathered on the root. Collective.
std::vector<parallel::NumberedRows> gather_at_nodes(
    const MotionContext& context, const std::vector<const std::vector<std::int32_t>*>& nodes,
    const std::vector<std::vector<double>>& values);

/// Kinetic energies of the components that a prescribed motion drives [J]: the drive supplies them.
std::vector<double> driven_kinetic(const MotionContext& context, const MotionState& state);

/// Writes the prescribed displacements and velocities at `time` into the owned part of the state.
void set_prescribed(const mechanics::BoundaryLoads& loads, double time, MotionState& state);

}  // namespace crackle::dynamics
