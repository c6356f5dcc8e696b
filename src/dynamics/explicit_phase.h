// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "dynamics/energy_account.h"
#include "dynamics/integrator.h"
#include "dynamics/moving_body.h"
#include "dynamics/sample_result.h"
#include "dynamics/stable_step.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace crackle::dynamics {

/// A state variable exceeded its number format; the message says which. Thrown on every rank.
class NumberRangeExceeded : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Action after a poll; the strongest request of any rank applies.
enum class Request : int {
  go_on,
  save,    ///< write a checkpoint and continue
  suspend  ///< write a checkpoint and stop
};

/// Steps between polls of whether a phase has arrested, failed, or should save or be suspended: each poll
/// requires communication.
inline constexpr std::int64_t steps_per_poll = 32;

struct PhaseResult {
  bool arrested = false;
  bool separated = false;  ///< the body had separated when the phase ended
  bool suspended = false;  ///< the rest is undefined
  double time = 0;         ///< duration of the phase until it ended [s]
  /// Time since the start of the phase of the last loss of stiffness before the conditions were found to act
  /// on separate pieces; NaN if they were not [s].
  double separated_at = not_a_number;
  double last_break = 0;  ///< time of the last loss of stiffness, likewise [s]
  /// Breaks up to this time count if this is the last phase: at most the duration [s].
  double end_time = 0;
  std::string note;          ///< reason for an unplanned early end
  double kinetic = 0;        ///< kinetic energy at the end [J]
  double external_work = 0;  ///< external work in the phase [J]
  double dissipated = 0;     ///< dissipated in the phase by terms, and what they no longer store at rest [J]
  std::int64_t n_steps = 0;
  std::int64_t n_forces = 0;
  std::vector<EnergyRow> energy;
  std::vector<Frame> frames;                    ///< root only
  std::vector<FragmentCount> fragment_history;  ///< at some energy rows; root only
  /// After the last output that counts; root only.
  Fragments fragments;
};

struct PhaseOptions {
  TimeGrid grid{};
  /// A phase without a break for this long has arrested [s]; empty: it runs for its full duration. If set, a
  /// phase in which breaking continues after the duration goes on without outputs, for at most
  /// max_phase_durations durations.
  std::optional<double> arrest_window = {};
  /// The window counts from the first break of the phase on; without one the phase arrests after its
  /// duration.
  bool awaits_break = false;
  std::optional<double> after_separation = {};  ///< a phase ends this long after separation of the body [s]
  bool ends_out_of_range = false;  ///< after separation, numbers out of range end the phase without a failure
  bool freezes = false;            ///< loose pieces whose numbers are about to leave their range stand still
  int n_frames = 0;                ///< frames over the whole duration, including first and last
  int n_energy_rows = 200;         ///< approximate number of rows of the energy account
  /// Interval of the history's rows [s]; empty: that of the energy rows.
  std::optional<double> history_interval = {};
  /// Times in the phase at which loads turn, ascending [s].
  std::vector<double> kinks = {};
  /// Called on every rank with the current energies and state, at the intervals of the history, of the energy
  /// rows and at the steps around kinks; may be empty.
  /// @param is_output a row of the history is due
  std::function<void(const EnergyRow& row, const MotionState& state, bool is_output)> on_history = {};
  std::function<void(const EnergyRow& row)> on_row =
      {};                                 ///< called for each of them, on every rank; may be empty
  std::function<Request()> request = {};  ///< this rank's request, polled regularly; may be empty
  /// Receives the state of the phase: the running phase, and the outputs so far. Called on every rank; may be
  /// empty.
  std::function<void(RunningPhase phase, const PhaseResult& so_far)> save = {};
  /// Called on every rank when the phase's first tetrahedra are about to break; may be empty. Until then
  /// every step requires a reduction over the ranks.
  std::function<void(double time, const MotionState& state)> on_first_break = {};
  /// Receives the partial result of a phase that fails; on every rank, may be empty.
  std::function<void(PhaseResult partial)> on_failure = {};
  /// The context's loads, which end on fragments that come loose; nullptr: they continue.
  mechanics::Conditions* ending_loads = nullptr;
  const Checkpoint* from = nullptr;  ///< resumes this checkpoint's running phase
};

/// Explicit dynamics with fracture: the splitting's stages, the breaking check at the end of every step, then
/// outputs. On return `state` is the final state. Collective.
/// @param motion of the context's body, at the phase's start
/// @param load_time time of the load curves at the phase's start [s]
/// @throws NumberRangeExceeded when the motion is no longer valid
/// @throws parallel::AgreedError at most 32 steps after anything in a step failed on any rank
PhaseResult run_explicit_phase(const MotionContext& context, MovingBody& motion, const Splitting& splitting,
                               const EnergyAccount& account, double load_time, const PhaseOptions& options,
                               MotionState& state);

}  // namespace crackle::dynamics
