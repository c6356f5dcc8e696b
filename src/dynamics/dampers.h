// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/moving_body.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace crackle::dynamics {

/// Mass-proportional damping and absorbing faces: forces -(a m + C) v on the nodes, with the rate a of the
/// context and the impedances C of the loads' absorbers. Components that a motion prescribes are left alone.
///
/// They act in the middle of Verlet's drift (Strang's splitting, order 2), by the trapezoidal rule, which is
/// stable for every step and needs no functions whose bits depend on the mathematical library. So the
/// velocity at the end of a step is the one that the dampers' force follows from; at the ends of the step
/// they would leave the velocities of absorbing nodes, which they take away within few steps, off by a fifth.
class Dampers {
public:
  explicit Dampers(const MotionContext& context);

  /// Whether there are any, on any rank.
  bool act() const { return context_.damping_rate != 0 || !context_.loads->absorbers.empty(); }

  /// Slows owned nodes [first, last) down in the middle of a drift that has been done. Local.
  /// @param duration of the drift [s]
  /// @param motion velocity(node, component), and change(node, component, change), which adds to the velocity
  ///   and takes the node where the drift would then have taken it; it returns what rounding has let it add:
  ///   the rest is carried on, so that slow motion is damped as fast motion is
  /// @param unit of these velocities [m/s]
  template <class Motion>
  void slow_down(std::int32_t first, std::int32_t last, double duration, Motion& motion, double unit);

  /// Energy taken out since the start [J]. Collective; equal bits for any number of ranks.
  double dissipated_energy() const;

  /// Adds what the dampers remember of each node. Collective.
  void save(MotionCheckpoint& checkpoint) const;
  /// Takes it back. Local.
  void restore(const MotionCheckpoint& checkpoint);

private:
  /// A node whose components are not damped alike.
  struct Node {
    std::int32_t node;
    mechanics::Symmetric rate;                    // of -dv/dt over v [1/s]
    std::array<std::array<double, 3>, 3> change;  // of the velocity in the last duration, over the velocity
  };
  struct Memory {
    std::array<double, 3> remainder{};  // what rounding has kept from the velocity
    double dissipated = 0;              // [J]
  };

  void set_duration(double duration);

  /// @param relative of a component: its change, given the velocity
  template <class Motion, class Relative>
  void slow_down(std::int32_t node, Motion& motion, double unit, const Relative& relative);

  MotionContext context_;
  std::vector<Node> nodes_;     // ascending
  std::vector<Memory> memory_;  // of owned nodes; empty without dampers
  double duration_ = 0;         // that the changes hold for
  double change_ = 0;           // of the other nodes' velocities, over the velocity
};

template <class Motion, class Relative>
void Dampers::slow_down(std::int32_t node, Motion& motion, double unit, const Relative& relative) {
  Memory& memory = memory_[static_cast<std::size_t>(node)];
  std::array<double, 3> before{};
  for (std::size_t c = 0; c < 3; ++c) before[c] = motion.velocity(node, c);
  double lost = 0;  // of the velocity's square
  for (std::size_t c = 0; c < 3; ++c) {
    const double wanted = relative(before, c) + memory.remainder[c];
    const double changed = motion.change(node, c, wanted);
    memory.remainder[c] = wanted - changed;
    lost -= changed * (2 * before[c] + changed);
  }
  const double mass = context_.body->operators().node_mass[static_cast<std::size_t>(node)];
  memory.dissipated += 0.5 * mass * (unit * unit * lost);
}

template <class Motion>
void Dampers::slow_down(std::int32_t first, std::int32_t last, double duration, Motion& motion, double unit) {
  if (memory_.empty()) return;
  set_duration(duration);
  auto special = std::ranges::lower_bound(nodes_, first, {}, &Node::node);
  for (std::int32_t n = first; n < last; ++n) {
    if (special != nodes_.end() && special->node == n) {
      const auto& change = special->change;
      slow_down(n, motion, unit, [&](const std::array<double, 3>& v, std::size_t c) {
        return change[c][0] * v[0] + change[c][1] * v[1] + change[c][2] * v[2];
      });
      ++special;
    } else if (change_ != 0) {
      slow_down(n, motion, unit,
                [&](const std::array<double, 3>& v, std::size_t c) { return change_ * v[c]; });
    }
  }
}

}  // namespace crackle::dynamics
