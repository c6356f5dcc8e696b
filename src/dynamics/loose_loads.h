// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/checkpoint.h"
#include "crackle/fracture/breakable_body.h"
#include "crackle/mechanics/boundary_loads.h"
#include "crackle/parallel/communicator.h"
#include "crackle/parallel/node_layout.h"
#include "crackle/parallel/numbered_rows.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// Where forces, tractions and pressures still act although their fragment has come loose: gas vents past it,
/// and a platen does not follow it. A piece is loose when no support, drive or absorbing face holds it
/// against the load, unless it has the largest share of the condition's loaded area and is no splinter (see
/// separated_share).
/// @param labels of the pieces, see fracture::piece_labels()
/// @return nothing, on every rank, when there is no such node on any rank. Collective.
std::optional<mechanics::NodesOfConditions> nodes_of_loose_pieces(const parallel::Communicator& group,
                                                                  const fracture::BreakableBody& body,
                                                                  const mechanics::BoundaryLoads& loads,
                                                                  const std::vector<std::int64_t>& labels);

/// Gathers the nodes where loads have ended, for each condition, on the root; empty when none has.
/// Collective.
std::vector<parallel::NumberedRows> gather_ended_loads(const parallel::Communicator& group,
                                                       const parallel::NodeLayout& layout,
                                                       const mechanics::BoundaryLoads& loads);
/// Ends them again. Collective.
/// @param ended as gathered, on every rank
void restore_ended_loads(const parallel::Communicator& group, const parallel::NodeLayout& layout,
                         const std::vector<parallel::NumberedRows>& ended, mechanics::BoundaryLoads& loads);

/// When a dynamic phase looks for loads on loose fragments: at fixed steps, and only where breaking may have
/// set one loose. To cut a fragment out of a connected loaded face takes a break at one of its nodes; a
/// break elsewhere can cut off a whole part of the body, which is looked for less often.
class LoadWatch {
public:
  LoadWatch(const fracture::BreakableBody& body, const mechanics::BoundaryLoads& loads, std::int64_t n_steps);

  /// The same steps on every rank.
  bool is_due(std::int64_t step) const { return has_loads_ && step % interval_ == 0; }
  /// Takes note of tetrahedra that carry less since this step. Local.
  void note(std::span<const std::int32_t> changed, std::int64_t step);
  /// True if a look is due now. Collective; does not agree() before.
  /// @param last_break step, as far as this rank knows
  bool must_look(const parallel::Communicator& group, std::int64_t step, std::int64_t last_break);
  /// Agreed, for a checkpoint. Collective; does not agree() before.
  LoadLook state(const parallel::Communicator& group) const;
  void restore(const LoadLook& state) { state_ = state; }

private:
  const fracture::BreakableBody* body_;
  std::vector<std::uint8_t> is_loaded_;  // of each local node, on the rank that owns it
  std::int64_t interval_;
  bool has_loads_;
  LoadLook state_;
};

}  // namespace crackle::dynamics
