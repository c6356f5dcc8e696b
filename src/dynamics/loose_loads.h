// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/checkpoint.h"
#include "fracture/breakable_body.h"
#include "mechanics/conditions.h"
#include "parallel/communicator.h"
#include "parallel/node_layout.h"
#include "parallel/numbered_rows.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// Finds the nodes where forces, tractions and pressures still act although their fragment has come loose:
/// gas vents past it, and a platen does not follow it. A piece is loose if no support, drive or absorbing
/// face supports it against the load, unless it has the largest share of the condition's loaded area and is
/// not a splinter (see separated_share). Collective.
/// @param labels of the pieces, see fracture::piece_labels()
/// @return empty on every rank if there is no such node on any rank
std::optional<mechanics::NodesOfConditions> nodes_of_loose_pieces(const parallel::Communicator& group,
                                                                  const fracture::BreakableBody& body,
                                                                  const mechanics::Conditions& loads,
                                                                  const std::vector<std::int64_t>& labels);

/// Finds the nodes where body forces still act although no face connects them with a support: splinters,
/// which fall off during quasi-static loading, and would have no equilibrium. Collective.
/// @return empty on every rank if there is no such node on any rank
std::optional<mechanics::NodesOfConditions> nodes_of_falling_splinters(const parallel::Communicator& group,
                                                                       const fracture::BreakableBody& body,
                                                                       const mechanics::Conditions& loads);

/// Gathers the nodes where loads have ended, by condition, on the root; empty if there are none. Collective.
std::vector<parallel::NumberedRows> gather_ended_loads(const parallel::Communicator& group,
                                                       const parallel::NodeLayout& layout,
                                                       const mechanics::Conditions& loads);
/// Ends these loads again. Collective.
/// @param ended as gathered, on every rank
void restore_ended_loads(const parallel::Communicator& group, const parallel::NodeLayout& layout,
                         const std::vector<parallel::NumberedRows>& ended, mechanics::Conditions& loads);

/// Schedules the checks for loads on loose fragments in a dynamic phase: at fixed steps, and only if breaking
/// may have set a fragment loose. Cutting a fragment out of a connected loaded face requires a break at one
/// of its nodes; breaks elsewhere can cut off a whole part of the body, which is checked less often.
class LoadWatch {
public:
  LoadWatch(const fracture::BreakableBody& body, const mechanics::Conditions& loads, std::int64_t n_steps);

  /// Equal on every rank.
  bool is_due(std::int64_t step) const { return has_loads_ && step % interval_ == 0; }
  /// Records tetrahedra that lost stiffness since this step. Local.
  void note(std::span<const std::int32_t> changed, std::int64_t step);
  /// True if a check is due now. Collective; does not call check_peers() before.
  /// @param last_break step, as known to this rank
  bool must_check(const parallel::Communicator& group, std::int64_t step, std::int64_t last_break);
  /// Agreed state for a checkpoint. Collective; does not call check_peers() before.
  LoadCheck state(const parallel::Communicator& group) const;
  void restore(const LoadCheck& state) { state_ = state; }

private:
  const fracture::BreakableBody* body_;
  std::vector<std::uint8_t> is_loaded_;  // per local node, set on its owner
  std::int64_t interval_;
  bool has_loads_;
  LoadCheck state_;
};

}  // namespace crackle::dynamics
