// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/large_vector.h"
#include "dynamics/moving_body.h"
#include "kernels/kernels.h"
#include "mechanics/fixed_point_scale.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

namespace crackle::dynamics {

/// A number in quanta, rounded to nearest. A value that does not fit the type gives 0 and clears `in_range`,
/// which is otherwise unchanged.
template <class Number>
Number quantized(double value, double quantum, bool& in_range) {
  constexpr double limit = sizeof(Number) == 4 ? 0x1p31 - 1 : 0x1p62;
  const double quanta = value / quantum;
  if (std::abs(quanta) < limit) return static_cast<Number>(std::llrint(quanta));
  in_range = false;
  return 0;
}

/// The low digits of a displacement in quanta, as stored in a node record.
template <class Real>
kernels::Integer<Real> low_digits(std::int64_t quanta) {
  return static_cast<kernels::Integer<Real>>(quanta);
}

/// Displacement and velocity in quanta. The displacements are stored in the node records used by the force,
/// which hold the low digits only; this class keeps the high ones. Nothing here is collective.
template <class Real>
class FixedPointState {
public:
  using Integer = kernels::Integer<Real>;

  /// Rounds the state to the format; see starts_in_range().
  /// @param nodes records of the local nodes, which must outlive the object
  FixedPointState(const geometry::Subdomain& subdomain, const mechanics::FixedPointScale& scale,
                  std::span<kernels::NodeRecord<Real>> nodes, const MotionState& start);

  /// True if the initial state fits the format.
  bool starts_in_range() const { return starts_in_range_; }

  std::span<kernels::NodeRecord<Real>> nodes() const { return nodes_; }  ///< local
  std::span<kernels::Velocity<Real>> velocity() { return velocity_; }    ///< of owned nodes
  std::span<const kernels::Velocity<Real>> velocity() const { return velocity_; }

  /// Component of a local node's displacement, in quanta, including the digits missing from its record: the
  /// value at the last unwrap() plus the movement since, which is small.
  std::int64_t whole_displacement(std::size_t node, std::size_t component) const {
    const std::int64_t last = whole_[node][component];
    return last + kernels::difference(nodes_[node].displacement[component], low_digits<Real>(last));
  }

  /// The same at the start of the last step (1) or of the one before (2).
  std::int64_t whole_displacement_before(std::size_t node, std::size_t component, int n_steps) const {
    return whole_displacement(node, component) -
           kernels::difference(nodes_[node].displacement[component],
                               displacement_before(node, n_steps)[component]);
  }

  /// Call before a step moves anything: displacement_before() is then one step further back.
  void begin_step() { std::swap(before_[0], before_[1]); }
  /// Stores the displacements of local nodes [first, last) at the start of a step. Required for all nodes in
  /// every step, by this or by the kernel that moves them.
  void keep_displacements(std::size_t first, std::size_t last) {
    for (std::size_t n = first; n < last; ++n)
      std::memcpy(before_[0][n].data(), &nodes_[n], sizeof before_[0][n]);
  }
  /// Where they are stored, from node `first` on.
  Integer (*kept_displacements(std::size_t first))[4] {
    return reinterpret_cast<Integer(*)[4]>(before_[0].data() + first);
  }
  /// Low digits of a local node's displacement at the start of the last step (1) or of the one before (2).
  const std::array<Integer, 4>& displacement_before(std::size_t node, int n_steps) const {
    return before_[n_steps == 1 ? 0 : 1][node];
  }

  /// Updates the high digits; call before any displacement changes by half of the records' range.
  void unwrap();

  /// Copies the state in SI units: displacements with ghosts, velocities of owned nodes.
  void read(MotionState& state) const;

  /// Rows of a checkpoint for the owned nodes: displacement, velocity and displacement at the start of the
  /// last step, and optionally the force.
  parallel::NumberedRows rows(bool with_force) const;
  /// Restores the state from these rows.
  /// @throws std::runtime_error when a local node is missing
  void restore(const parallel::NumberedRows& rows, bool with_force);

private:
  const geometry::Subdomain* subdomain_;
  mechanics::FixedPointScale scale_;
  std::span<kernels::NodeRecord<Real>> nodes_;
  LargeVector<kernels::Velocity<Real>> velocity_;
  // Displacements of local nodes at the starts of steps; padded to four numbers so that a copy is a single
  // move.
  std::array<LargeVector<std::array<Integer, 4>>, 2> before_;
  std::vector<std::array<std::int64_t, 3>> whole_;  // displacements of local nodes at the last unwrapping
  bool starts_in_range_ = true;
};

}  // namespace crackle::dynamics
