// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"
#include "crackle/dynamics/energy_account.h"
#include "crackle/dynamics/integrator.h"
#include "crackle/dynamics/moving_body.h"
#include "crackle/dynamics/sample_result.h"
#include "crackle/dynamics/stable_step.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace crackle::dynamics {

/// The state of a motion outgrew its number format; the message says which quantity. Thrown on every rank.
class NumberRangeExceeded : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// What a phase does after a poll; the ranks' most far-reaching request counts.
enum class Request : int {
  go_on,
  save,  ///< a checkpoint, and on
  park   ///< a checkpoint, and no further
};

/// Steps between two polls of whether a phase has arrested, failed or is to save or park: each poll
/// costs messages between the ranks.
inline constexpr std::int64_t steps_per_poll = 32;

struct PhaseResult {
  bool arrested = false;
  bool separated = false;  ///< the body was apart when the phase ended
  bool parked = false;     ///< the rest is undefined
  double time = 0;         ///< at which the phase ended, since its start [s]
  /// Since the phase's start, of the last break before the conditions were found to share no piece; where
  /// they were not, NaN [s].
  double separated_at = not_a_number;
  double last_break = 0;  ///< likewise, of the last break [s]
  /// Up to which its breaks count, should it be the last phase: the duration at most [s].
  double counted_time = 0;
  std::string note;          ///< why it ended early, where that was no plan
  double kinetic = 0;        ///< energy then [J]
  double external_work = 0;  ///< of the phase [J]
  double dissipated = 0;     ///< in the phase, by damping and absorbing faces [J]
  std::int64_t n_steps = 0;
  std::int64_t n_forces = 0;
  std::vector<EnergyRow> energy;
  std::vector<Frame> frames;  ///< root only
};

struct PhaseOptions {
  TimeGrid grid{};
  /// A phase without a break for this long has arrested [s]; empty: it ends with its duration. With it, a
  /// phase that breaks on when the duration is over goes on without outputs, to at most max_phase_durations
  /// durations.
  std::optional<double> arrest_window = {};
  std::optional<double> after_separation = {};  ///< a phase ends this long after the body came apart [s]
  bool ends_out_of_range =
      false;                ///< once the body is apart, numbers out of range end the phase and are no failure
  int n_frames = 0;         ///< frames over the whole duration, first and last included
  int n_energy_rows = 200;  ///< about this many rows of the energy account
  /// Between two calls of on_history [s]; empty: as between rows of the energy account.
  std::optional<double> history_interval = {};
  /// Called on every rank with the energies and the state then; may be empty.
  std::function<void(const EnergyRow& row, const MotionState& state)> on_history = {};
  std::function<void(const EnergyRow& row)> on_row =
      {};                                 ///< called for each of them, on every rank; may be empty
  std::function<Request()> request = {};  ///< this rank's request, at every poll; may be empty
  /// Takes the phase's state: the running phase, and energy rows and frames so far, on the root. Called on
  /// every rank; may be empty.
  std::function<void(RunningPhase phase, const std::vector<EnergyRow>& energy,
                     const std::vector<Frame>& frames)>
      save = {};
  /// Called on every rank when the phase's first tetrahedra are about to break; may be empty. Until then
  /// every step takes a message between the ranks.
  std::function<void(double time, const MotionState& state)> on_first_break = {};
  /// Takes what there is of a phase that fails; on every rank, may be empty.
  std::function<void(PhaseResult partial)> on_failure = {};
  /// The context's loads, to end on fragments that come loose; nullptr: they go on.
  mechanics::BoundaryLoads* ending_loads = nullptr;
  const Checkpoint* from = nullptr;  ///< continues from its running phase
};

/// Explicit dynamics with breaking: the splitting's stages, at the end of every step the breaking check, then
/// outputs. On return `state` is the last one. Collective.
/// @param motion of the context's body, at the phase's start
/// @param load_time time of the load curves at the phase's start [s]
/// @throws NumberRangeExceeded when the motion's state can no longer be trusted
/// @throws parallel::AgreedError at most 32 steps after anything in a step failed on any rank
PhaseResult run_explicit_phase(const MotionContext& context, MovingBody& motion, const Splitting& splitting,
                               const EnergyAccount& account, double load_time, const PhaseOptions& options,
                               MotionState& state);

}  // namespace crackle::dynamics
