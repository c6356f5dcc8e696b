// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/integrator.h"

#include "external_work.h"
#include "fixed_point_state.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace crackle::dynamics {

/// The loaded and driven nodes in fixed point, block by block: their additional updates besides the common
/// kick and drift of a block, and the associated work.
template <class Real>
class BoundaryNodes {
public:
  /// The references must outlive the object.
  /// @param nodes_per_block size of the consecutive blocks of the state's nodes
  BoundaryNodes(const MotionContext& context, const mechanics::FixedPointScale& scale,
                std::int32_t nodes_per_block, FixedPointState<Real>& state, ExternalWork& work);

  /// True if some of a block's nodes are loaded or driven.
  bool acts_on(std::size_t block) const {
    return !blocks_[block].loaded.empty() || !blocks_[block].driven.empty();
  }

  /// Saves the driven velocities, which the kick must not change.
  void before_kick(std::size_t block, const Substep& substep);
  /// Restores them, and applies the kicks of the loads.
  void after_kick(std::size_t block, const Substep& substep);
  /// Moves driven nodes to their prescribed displacements.
  /// @param movement of the block in the drift; extended by the movement of driven nodes
  void after_drift(std::size_t block, const Substep& substep, kernels::Movement<double>& movement);

  /// True if every driven displacement and velocity and every kick of a load has fitted the format so far.
  bool stays_in_range() const { return stays_in_range_; }

  /// Adds the rounding remainders to the checkpoint. Collective.
  void save(MotionCheckpoint& checkpoint) const;
  /// Restores them from the checkpoint. Local.
  void restore(const MotionCheckpoint& checkpoint);

private:
  using Integer = kernels::Integer<Real>;

  struct Entry {
    std::uint32_t condition;  // number of the pattern or motion
    std::uint32_t place;      // index in its list of nodes
    std::int32_t node;
    std::int16_t component;
    bool is_driven;      // of a loaded component: it is also prescribed by a motion
    Integer velocity;    // of driven components, before the kick
    double remainder;    // of a loaded component: accumulated rounding error of the velocity, in quanta
    double per_impulse;  // of a loaded component: change of velocity per impulse [quanta / (N s)]
  };
  struct Block {
    std::vector<Entry> loaded;
    std::vector<Entry> driven;
  };

  /// The amplitude of a force pattern in a kick.
  struct Amplitude {
    double value;
    double slope;
  };

  Integer& velocity(const Entry& entry);
  void keep_velocity(Entry& entry, const Substep& substep);
  void kick_by_load(Entry& entry, const Substep& substep, const Amplitude& amplitude);
  double drive(const Entry& entry, const Substep& substep);

  MotionContext context_;
  mechanics::FixedPointScale scale_;
  FixedPointState<Real>* state_;
  ExternalWork* work_;
  std::vector<Block> blocks_;
  bool stays_in_range_ = true;
};

}  // namespace crackle::dynamics
