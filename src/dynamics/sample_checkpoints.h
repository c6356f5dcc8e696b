// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/stopwatch.h"
#include "dynamics/checkpoint.h"
#include "dynamics/explicit_phase.h"
#include "dynamics/sample_run.h"
#include "dynamics/sample_setup.h"

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <vector>

namespace crackle::dynamics {

/// The checkpoint belongs to a different sample.
class CheckpointMismatch : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// The checkpoints of a sample: the one that this run continues from, and those that it saves.
class SampleCheckpoints {
public:
  /// The references must outlive the object.
  /// @param from nullptr: the run begins at the start
  SampleCheckpoints(SampleSetup& setup, const SampleControl& control, const Checkpoint* from);

  /// True if checkpoints are saved, which all ranks know.
  bool are_saved() const { return static_cast<bool>(control_->save); }
  /// This rank's request: to suspend the sample, or on the root to save if that is due.
  Request request() const;

  /// A phase that an earlier run has completed; nullptr if this run must compute it.
  /// @param phase number, from 1
  /// @throws CheckpointMismatch if the phase began at another load time, or on another mesh
  const EndedPhase* ended(std::int64_t phase, double load_time) const;
  /// The checkpoint, if it holds this phase in progress; otherwise nullptr.
  /// @throws CheckpointMismatch if the phase began at another load time
  const Checkpoint* running(std::int64_t phase, double load_time) const;
  /// Restores an arrested phase of the checkpoint: its releases, ended loads and final displacement; it is
  /// part of later checkpoints. Collective.
  /// @return the checkpoint
  const Checkpoint& restore(const EndedPhase& phase, MotionState& state);

  /// Adds an arrested phase to later checkpoints. Local.
  void add(EndedPhase phase) { ended_.push_back(std::move(phase)); }
  /// An arrested phase, with what restore() needs. Collective.
  EndedPhase gather(const PhaseResult& phase, double load_time, const ReleasesSince& releases,
                    const MotionState& state, std::vector<HistoryRow> history) const;

  /// True if more phases have ended than in the checkpoint that this run continues from.
  bool is_past_start() const { return ended_.size() > (from_ == nullptr ? 0 : from_->ended.size()); }
  /// Saves a checkpoint; a failure is logged, and does not end the sample. Collective.
  /// @param running the phase in progress, if any
  void save(std::optional<RunningPhase> running, const std::vector<EnergyRow>& energy,
            const std::vector<Frame>& frames, const std::vector<FragmentCount>& fragment_history);

  /// The machine's reaction at the first break, if that was in a dynamic phase [N].
  double first_break_reaction = 0;

private:
  SampleSetup* setup_;
  const SampleControl* control_;
  const Checkpoint* from_;
  std::vector<EndedPhase> ended_;  // their rows on the root, or from the checkpoint
  Stopwatch since_save_;
};

}  // namespace crackle::dynamics
