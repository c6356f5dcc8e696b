// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/explicit_phase.h"

#include <cstdint>
#include <vector>

namespace crackle::dynamics {

/// The outputs of a dynamic phase during its duration: rows of the energy account, history, frames and
/// fragments.
class PhaseOutput {
public:
  /// Collective. The references must outlive the object.
  /// @param load_time time of the load curves at the start of the phase [s]
  /// @param state receives the current state at every output
  /// @param result receives energy rows, frames and fragments
  PhaseOutput(const MotionContext& context, const MovingBody& motion, const EnergyAccount& account,
              double load_time, const PhaseOptions& options, MotionState& state, PhaseResult& result);

  /// True if anything is due after this step; step 0 is the start.
  bool is_due(std::int64_t step) const;

  /// Measures the energies and writes what is due. Collective.
  /// @param is_last the phase ends here: an energy row and a history row are due in any case
  /// @throws std::runtime_error on every rank when the energies show that the motion is invalid
  void write(std::int64_t step, bool is_last);

  /// The phase continues from a checkpoint, whose pieces are the last ones known. Collective.
  void start_again();
  /// Takes the fragments at their last count as those of the end. Collective.
  void write_last_fragments();

private:
  bool is_frame(std::int64_t step) const;
  bool is_energy_row(std::int64_t step) const;
  bool is_count(std::int64_t step) const;  ///< of fragments, at an energy row
  bool is_history_row(std::int64_t step) const;
  /// True if the history is measured, for a row or for the machine's results.
  bool is_measured(std::int64_t step) const;
  EnergyRow measure(double time) const;
  Frame frame(double time) const;
  void write_fragments(double time);
  void remember_motion();

  MotionContext context_;
  const MovingBody* motion_;
  const EnergyAccount* account_;
  double load_time_;
  const PhaseOptions* options_;
  MotionState* state_;
  PhaseResult* result_;
  std::int64_t row_interval_, history_interval_;  // in steps
  std::vector<std::int64_t> frame_steps_;         // ascending
  std::vector<std::int64_t> kink_steps_;          // around those of the loads, ascending
  double negligible_energy_;                      // that rounding alone may produce [J]
  // The last count of fragments:
  bool has_labels_ = false;
  FragmentCount count_;                          // on the root
  std::vector<std::int64_t> labels_;             // of the pieces
  std::vector<double> displacement_, velocity_;  // of owned nodes
};

/// Kinetic energy of each owned node [J]. Local.
std::vector<double> kinetic_energies(const MotionContext& context, const MotionState& state);

/// Kinetic energy of the lumped masses [J]. Collective; bitwise equal for any number of ranks.
double kinetic_energy(const MotionContext& context, const MotionState& state);

}  // namespace crackle::dynamics
