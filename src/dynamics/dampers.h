// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/moving_body.h"
#include "dynamics/term.h"

#include "viscous_force.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace crackle::dynamics {

/// Mass-proportional damping and absorbing faces: nodal forces -(a m + C) v, with the rate a of the context
/// and the impedances C of the loads' absorbers; and bulk viscosity. Prescribed components are not damped.
///
/// The former act in the middle of Verlet's drift (Strang splitting, order 2) by the trapezoidal rule, which
/// is unconditionally stable and needs no functions whose bits depend on the mathematical library. Thus the
/// velocity at the end of a step is consistent with the damping force; if applied at the ends of the step,
/// the velocities of absorbing nodes, which decay within a few steps, would be wrong by a fifth.
class Dampers final : public Term {
public:
  /// The context's members must outlive the object.
  Dampers(const MotionContext& context, std::int32_t nodes_per_block);

  /// Damps the nodes in the middle of a drift that has already been applied.
  void after_drift(std::size_t block, const Substep& substep, MovingNodes& nodes) override;
  /// Applies the viscous forces for the duration of the step. Those on driven components act on their drives.
  void end_step(const mechanics::StepSpan& step, MovingNodes& nodes, const Drives& drives) override;
  void add_dissipated(std::vector<double>& sum) const override;
  void measure(double time, const parallel::NodeField& displacement, const parallel::NodeField* velocity,
               LoadState& state) const override;
  bool dissipates() const override { return act() || context_.bulk_viscosity.acts(); }
  std::vector<parallel::NumberedRows> save() const override;
  void restore(const std::vector<parallel::NumberedRows>& rows) override;

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

  /// True if there are dampers on any rank.
  bool act() const { return context_.damping_rate != 0 || !context_.loads->absorbers.empty(); }
  void set_duration(double duration);

  /// Changes the velocity of a node. The rounding error is carried over, so that slow motion is damped like
  /// fast motion.
  /// @param change of a component, given the velocity
  /// @param duration as for MovingNodes::change_velocity()
  template <class Change>
  void slow_down(std::int32_t node, MovingNodes& nodes, double duration, const Change& change);

  MotionContext context_;
  std::int32_t nodes_per_block_;
  ViscousForce viscosity_;
  std::vector<Vector> moved_, viscous_force_;  // of local nodes in the last step; empty without viscosity
  std::vector<Node> nodes_;                    // ascending
  std::vector<Memory> memory_;                 // of owned nodes; empty without dampers and bulk viscosity
  double duration_ = 0;                        // for which the changes are computed [s]
  double change_ = 0;                          // relative velocity change of the other nodes
};

}  // namespace crackle::dynamics
