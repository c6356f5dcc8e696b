// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "external_work.h"
#include "fixed_point_state.h"
#include "substeps.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace crackle::dynamics {

/// The nodes that loads act on or motions drive, in fixed point and block by block: what they need besides
/// the kick and the drift that all nodes of a block get, and the work that goes with it.
template <class Real>
class BoundaryNodes {
public:
  /// The references must outlive the object.
  /// @param nodes_per_block of the state's nodes, from the first one on
  BoundaryNodes(const MotionContext& context, const mechanics::FixedPointScale& scale,
                std::int32_t nodes_per_block, FixedPointState<Real>& state, ExternalWork& work);

  /// Notes the driven velocities, which the kick must not change.
  void before_kick(std::size_t block, const Substep& substep);
  /// Sets them again, and lets the loads kick.
  void after_kick(std::size_t block, const Substep& substep);
  /// Takes driven nodes to their places.
  /// @param movement of the block in the drift: widened by what they have moved
  void after_drift(std::size_t block, const Substep& substep, kernels::Movement<double>& movement);

  /// Whether the format could hold every driven displacement and velocity and every kick of a load so far.
  bool stays_in_range() const { return stays_in_range_; }

  /// Adds what rounding has kept so far. Collective.
  void save(MotionCheckpoint& checkpoint) const;
  /// Takes it back. Local.
  void restore(const MotionCheckpoint& checkpoint);

private:
  using Integer = kernels::Integer<Real>;

  struct Entry {
    std::size_t condition;  // number of the pattern or motion
    std::size_t place;      // in its list of nodes
    std::int32_t node;
    int component;
    bool is_driven;    // of a loaded component: a motion prescribes it too
    double remainder;  // of a loaded component: what rounding has kept from the velocity so far, in quanta
    Integer velocity;  // before the kick, of driven components
  };
  struct Block {
    std::vector<Entry> loaded;
    std::vector<Entry> driven;
  };

  Integer& velocity(const Entry& entry);
  void keep_velocity(Entry& entry, const Substep& substep);
  void kick_by_load(Entry& entry, const Substep& substep);
  double drive(const Entry& entry, const Substep& substep);

  MotionContext context_;
  mechanics::FixedPointScale scale_;
  FixedPointState<Real>* state_;
  ExternalWork* work_;
  std::vector<Block> blocks_;
  bool stays_in_range_ = true;
};

}  // namespace crackle::dynamics
