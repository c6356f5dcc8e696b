// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/moving_body.h"

#include <span>
#include <vector>

namespace crackle::dynamics {

/// The work of the loads, consistent with the splitting.
///
/// A splitting conserves, to its order, T + U - F(t).u + the sum over kicks of F'(t).u dt. This class
/// computes the external part of that sum, so the energy balance closes to the integrator's order for any
/// load curve. Prescribed motions add the work of the internal forces on them, and their kinetic energy.
class ExternalWork {
public:
  /// @param state with the prescribed values at `time` set
  ExternalWork(const MotionContext& context, double time, const MotionState& state,
               std::span<const double> driven_kinetic_before);

  /// A kick with pattern k: the amplitude changes at constant displacement u of the pattern's node n.
  void add_rate(std::size_t k, std::size_t n, double duration_times_slope, double u) {
    const auto& pattern = context_.loads->forces[k];
    if (pattern.does_work_at(n)) rate_work_[k][n] += duration_times_slope * pattern.weight[n] * u;
  }
  /// Node n of motion m moves with `velocity` against the internal force f.
  void add_reaction(std::size_t m, std::size_t n, double duration_times_velocity, double f) {
    reaction_work_[m][n] += duration_times_velocity * f;
  }

  /// The loads are about to end at these nodes; the work done so far is kept.
  void end_loads(double time, const mechanics::NodesOfConditions& nodes, const MotionState& state);

  /// Adds the sums so far to the checkpoint, gathered on the root. Collective.
  void save(MotionCheckpoint& checkpoint) const;
  /// Restores them from the checkpoint. Local.
  void restore(const MotionCheckpoint& checkpoint);

  /// Since the start [J]. Collective.
  double value(double time, const MotionState& state) const;

private:
  std::vector<double> load_potential(double time, const MotionState& state) const;

  MotionContext context_;
  std::vector<std::vector<double>> rate_work_;      // by pattern and node
  std::vector<std::vector<double>> reaction_work_;  // by motion and node
  std::vector<double> start_;
};

/// Values at the nodes of conditions, one list per condition, as tables gathered on the root. Collective.
std::vector<parallel::NumberedRows> gather_at_nodes(
    const MotionContext& context, const std::vector<const std::vector<std::int32_t>*>& nodes,
    const std::vector<std::vector<double>>& values);

/// Kinetic energies of the driven components [J], supplied by the drive.
std::vector<double> driven_kinetic(const MotionContext& context, const MotionState& state);

/// Writes the prescribed displacements and velocities at `time` into the owned part of the state.
void set_prescribed(const mechanics::Conditions& loads, double time, MotionState& state);

}  // namespace crackle::dynamics
