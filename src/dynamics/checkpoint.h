// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "dynamics/sample_result.h"
#include "fracture/break_record.h"
#include "fracture/breakable_body.h"
#include "input/model.h"
#include "parallel/numbered_rows.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// Restart data of a MovingBody, besides what it is constructed from; keyed by node number, hence independent
/// of the partition. Integers are stored as such, floating-point numbers by their bits.
struct MotionCheckpoint {
  /// Per node: displacement, velocity, displacement at the start of the last step, force (if current).
  parallel::NumberedRows nodes;
  bool has_force = false;                                  ///< nodes have twelve words instead of nine
  std::vector<std::vector<parallel::NumberedRows>> terms;  ///< of each Term
  std::int64_t n_steps = 0;
  std::int64_t n_forces = 0;
  parallel::NumberedRows frozen = {};  ///< a row for each frozen node
  double frozen_energy = 0;            ///< taken from them [J]
};

/// A dynamic phase that has arrested.
struct EndedPhase {
  double load_time = 0;  ///< at its start [s]
  double time = 0;       ///< duration [s]
  double kinetic = 0;
  double external_work = 0;
  double dissipated = 0;
  double separated_at = not_a_number;  ///< as in PhaseResult [s]
  double last_break = 0;               ///< as in PhaseResult [s]
  std::int64_t n_steps = 0;
  std::int64_t n_forces = 0;
  fracture::Releases releases;
  parallel::NumberedRows displacement;  ///< of each node at the end of the phase, by bits
  std::vector<HistoryRow> history;
  /// Nodes at which loads have ended, by condition; empty if there are none.
  std::vector<parallel::NumberedRows> ended_loads = {};
  parallel::NumberedRows cuts = {};  ///< the contact of those that were there, by tetrahedron
};

/// Steps at which a dynamic phase checked for, and found, separation of the body.
struct Separation {
  std::int64_t checked_at = 0;        ///< step of the last check
  std::optional<std::int64_t> found;  ///< step at which the body was found separated
  /// Step of the last loss of stiffness before the conditions were found to act on separate pieces.
  std::optional<std::int64_t> unloaded;
};

/// Steps relevant to the checks of a dynamic phase for loads on loose fragments.
struct LoadCheck {
  std::int64_t checked_at = 0;
  std::int64_t broke_at = 0;  ///< last break of a tetrahedron at a loaded node
};

/// A dynamic phase in progress, between two steps.
struct RunningPhase {
  double load_time = 0;
  std::int64_t step = 0;
  std::int64_t last_break = 0;  ///< step of the last loss of stiffness
  Separation separation;
  fracture::Releases releases;
  MotionCheckpoint motion;
  std::vector<HistoryRow> history = {};  ///< so far
  LoadCheck load_check = {};
  std::vector<parallel::NumberedRows> ended_loads = {};  ///< as in EndedPhase
};

/// Checkpoint of a sample: its dynamic phases. The quasi-static loading between them is recomputed, bit for
/// bit.
struct Checkpoint {
  /// Precision of the phases: double if a mixed-precision run left its number range.
  input::Precision precision = input::Precision::mixed;
  input::Engine engine = input::Engine::fixed_point;  ///< likewise
  /// The machine's reaction at the first break, if that was in a dynamic phase [N].
  double first_break_reaction = 0;
  std::vector<EndedPhase> ended;
  std::optional<RunningPhase> running;
  parallel::NumberedRows memory;                     ///< non-zero memory of the criterion, by bits
  std::vector<EnergyRow> energy;                     ///< of the last phase
  std::vector<Frame> frames;                         ///< of the last phase; root only
  std::vector<FragmentCount> fragment_history = {};  ///< likewise
};

/// @return the root's checkpoint as bytes
std::vector<std::byte> to_bytes(const Checkpoint& checkpoint);

/// The root's bytes as a checkpoint on every rank, frames and fragments on the root only. Collective.
/// @throws std::runtime_error on every rank when the bytes are not a checkpoint
Checkpoint share_checkpoint(const parallel::Communicator& group, std::span<const std::byte> bytes);

/// Gathers the breaks of all ranks on the root, sorted by time, then by tetrahedron number. Collective.
std::vector<fracture::Break> gather_breaks(const parallel::Communicator& group,
                                           std::span<const fracture::Break> local);
/// As gather_breaks, for releases by the bridging rule.
std::vector<fracture::BridgeRelease> gather_bridge_releases(const parallel::Communicator& group,
                                                            std::span<const fracture::BridgeRelease> local);

/// As gather_breaks, for the stiffness reductions of softening tetrahedra; in order for each tetrahedron.
std::vector<fracture::StiffnessReduction> gather_stiffness_reductions(
    const parallel::Communicator& group, std::span<const fracture::StiffnessReduction> local);

/// Marks a point in a body's fracture history, to gather the releases after it.
class ReleasesSince {
public:
  explicit ReleasesSince(const fracture::BreakableBody& body)
      : body_(&body),
        n_breaks_(body.breaks().size()),
        n_bridge_releases_(body.bridge_releases().size()),
        n_stiffness_reductions_(body.stiffness_reductions().size()) {}
  /// Gathers the releases of all ranks on the root. Collective.
  fracture::Releases gather(const parallel::Communicator& group) const;

private:
  const fracture::BreakableBody* body_;
  std::size_t n_breaks_, n_bridge_releases_, n_stiffness_reductions_;
};

}  // namespace crackle::dynamics
