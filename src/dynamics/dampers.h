// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/moving_body.h"

#include "external_work.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// Mass-proportional damping and absorbing faces: nodal forces -(a m + C) v, with the rate a of the context
/// and the impedances C of the loads' absorbers; and bulk viscosity. Prescribed components are not damped.
///
/// The former act in the middle of Verlet's drift (Strang splitting, order 2) by the trapezoidal rule, which
/// is unconditionally stable and needs no functions whose bits depend on the mathematical library. Thus the
/// velocity at the end of a step is consistent with the damping force; if applied at the ends of the step,
/// the velocities of absorbing nodes, which decay within a few steps, would be wrong by a fifth.
class Dampers {
public:
  explicit Dampers(const MotionContext& context);

  /// True if there are dampers on any rank.
  bool act() const { return context_.damping_rate != 0 || !context_.loads->absorbers.empty(); }
  /// True if there is bulk viscosity.
  bool are_viscous() const { return context_.bulk_viscosity.acts(); }

  /// Damps owned nodes [first, last) in the middle of a drift that has already been applied. Local.
  /// @param duration of the drift [s]
  /// @param motion velocity(node, component) and change(node, component, change); the latter adds to the
  ///   velocity and corrects the displacement accordingly, and returns the change after rounding: the
  ///   remainder is carried over, so that slow motion is damped like fast motion
  /// @param unit of these velocities [m/s]
  template <class Motion>
  void slow_down(std::int32_t first, std::int32_t last, double duration, Motion& motion, double unit);

  /// Applies the viscous forces at the end of a step for its duration. Those on prescribed components act on
  /// their drives, and become 0. Local.
  /// @param force of owned nodes, see ViscousForce
  /// @param quantum of these forces [N]
  /// @param motion, unit as above; change() leaves displacements alone
  template <class Motion, class Number>
  void resist(const mechanics::StepSpan& step, std::span<std::array<Number, 3>> force, double quantum,
              Motion& motion, double unit, ExternalWork& work);

  /// Dissipated energy since the start [J]. Collective; bitwise equal for any number of ranks.
  double dissipated_energy() const;

  /// Adds the dampers' state of each node to the checkpoint. Collective.
  void save(MotionCheckpoint& checkpoint) const;
  /// Restores it from the checkpoint. Local.
  void restore(const MotionCheckpoint& checkpoint);

private:
  /// A node with anisotropic damping.
  struct Node {
    std::int32_t node;
    mechanics::Symmetric rate;  // -(dv/dt) / v [1/s]
    std::array<std::array<double, 3>, 3>
        change;  // change of the velocity over the last duration, relative to the velocity
  };
  struct Memory {
    std::array<double, 3> remainder{};  // accumulated rounding error of the velocity
    double dissipated = 0;              // [J]
  };

  void set_duration(double duration);

  /// @param relative change of a component, given the velocity
  template <class Motion, class Relative>
  void slow_down(std::int32_t node, Motion& motion, double unit, const Relative& relative);

  MotionContext context_;
  std::vector<Node> nodes_;     // ascending
  std::vector<Memory> memory_;  // of owned nodes; empty without dampers and bulk viscosity
  double duration_ = 0;         // for which the changes are computed [s]
  double change_ = 0;           // relative velocity change of the other nodes
};

template <class Motion, class Relative>
void Dampers::slow_down(std::int32_t node, Motion& motion, double unit, const Relative& relative) {
  Memory& memory = memory_[static_cast<std::size_t>(node)];
  std::array<double, 3> before{};
  for (std::size_t c = 0; c < 3; ++c) before[c] = motion.velocity(node, c);
  double lost = 0;  // decrease of the squared velocity
  for (std::size_t c = 0; c < 3; ++c) {
    const double wanted = relative(before, c) + memory.remainder[c];
    const double changed = motion.change(node, c, wanted);
    memory.remainder[c] = wanted - changed;
    lost -= changed * (2 * before[c] + changed);
  }
  const double mass = context_.body->operators().node_mass[static_cast<std::size_t>(node)];
  memory.dissipated += 0.5 * mass * (unit * unit * lost);
}

template <class Motion, class Number>
void Dampers::resist(const mechanics::StepSpan& step, std::span<std::array<Number, 3>> force, double quantum,
                     Motion& motion, double unit, ExternalWork& work) {
  const double duration = step.end - step.begin;
  for (std::size_t m = 0; m < context_.loads->motions.size(); ++m) {
    const auto& prescribed = context_.loads->motions[m];
    const double speed = prescribed.velocity(step.end, step);
    for (std::size_t n = 0; n < prescribed.nodes.size(); ++n) {
      const auto node = static_cast<std::size_t>(prescribed.nodes[n]);
      Number& f = force[node][static_cast<std::size_t>(prescribed.component)];
      const double displacement = duration * prescribed.factor_at(n) * speed;
      work.add_reaction(m, n, displacement, quantum * static_cast<double>(f));
      memory_[node].dissipated += displacement * (quantum * static_cast<double>(f));
      f = 0;
    }
  }
  const auto& mass = context_.body->operators().node_mass;
  for (std::size_t n = 0; n < force.size(); ++n) {
    const double per_force = -duration * quantum / (mass[n] * unit);
    slow_down(static_cast<std::int32_t>(n), motion, unit, [&](const std::array<double, 3>&, std::size_t c) {
      return per_force * static_cast<double>(force[n][c]);
    });
  }
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
