// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/moving_body.h"
#include "dynamics/term.h"
#include "mechanics/static_solver.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// All terms of one dynamic phase, and their sums. Calls are passed on in a fixed order, in which prescribed
/// motions undo what others do to their components, and damping follows the drive.
class Terms {
public:
  /// Those of the context. Local. The context's members must outlive the object.
  /// @param given the state at the start, before prescribe()
  /// @param nodes_per_block of the implementation
  Terms(const MotionContext& context, const MotionState& given, std::int32_t nodes_per_block);

  /// Those of a body at rest, which dampers do not act on. Collective. The context's members must outlive the
  /// object.
  explicit Terms(const MotionContext& context);

  void prescribe(double time, MotionState& state) const;
  void start(double time, const MotionState& state);

  /// True if a term acts on nodes of a block between the kick by the internal force and the drift.
  bool act_on(std::size_t block) const { return acts_[block] != 0; }
  void before_kick(std::size_t block, const Substep& substep, MovingNodes& nodes);
  void after_kick(std::size_t block, const Substep& substep, MovingNodes& nodes);
  void after_drift(std::size_t block, const Substep& substep, MovingNodes& nodes);
  bool couple_nodes() const;
  void add_forces(MovingNodes& nodes);
  void end_step(const mechanics::StepSpan& step, MovingNodes& nodes);
  void end_loads(double time, const mechanics::NodesOfConditions& nodes,
                 const parallel::NodeField& displacement);

  // Since the start of the phase [J]. Collective; bitwise equal for any number of ranks if the state is.
  double supplied(double time, const MotionState& state) const;
  double dissipated() const;
  double stored(const parallel::NodeField& displacement) const;
  double lost_at_rest(const parallel::NodeField& displacement) const;

  /// The measurements of all terms, see Term. Collective.
  LoadState measure(double time, const parallel::NodeField& displacement,
                    const parallel::NodeField* velocity) const;

  /// Of all terms together. Collective.
  Demand demand(double from, double to) const;

  // For a body at rest, see Term.
  auto begin() const { return terms_.begin(); }
  auto end() const { return terms_.end(); }
  /// By their kinds, otherwise in the order of the terms.
  std::vector<UnitLoad> unit_loads() const;
  /// 1 for each prescribed component, ghosts included. Collective.
  mechanics::HeldComponents held_components(const geometry::Subdomain& subdomain) const;
  /// The sums at each node, ascending.
  std::vector<NodeResponse> responses(double time, std::span<const double> displacement) const;
  /// Those of all terms, in their order.
  std::vector<double*> unknowns() const;
  std::vector<UnknownResponse> unknown_responses(double time, std::span<const double> displacement) const;
  /// As responses(), of what they add at most.
  std::vector<NodeResponse> stiffest(std::span<const double> no_displacement) const;

  /// Adds their state to the checkpoint. Collective.
  void save(MotionCheckpoint& checkpoint) const;
  /// Restores it. Local. @throws std::runtime_error when the checkpoint has other terms
  void restore(const MotionCheckpoint& checkpoint);

private:
  void find_blocks();

  const parallel::Communicator* group_;
  std::vector<std::unique_ptr<Term>> terms_;
  std::vector<std::uint8_t> acts_;  // by block
};

}  // namespace crackle::dynamics
