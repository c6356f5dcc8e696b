// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "dynamics/moving_body.h"
#include "dynamics/rigid_turning.h"
#include "dynamics/term.h"
#include "dynamics/tool_shape.h"
#include "input/tool.h"
#include "mechanics/load_curve.h"

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace crackle::dynamics {

/// A tool as it is found when the body is at rest, handed from the equilibria to the motion that follows.
struct ToolAtRest {
  /// The spring along the surface, see ToolTerm.
  struct Spring {
    Vector anchor{};   ///< displacement from the tool at which it is not stretched [m]
    Vector stretch{};  ///< [m]
  };
  Vector displacement{};                   ///< since the start [m]
  std::map<std::int32_t, Spring> springs;  ///< by owned node that it touches or almost does
};

/// Rigid tools that touch the body: a node inside a tool is pushed out along the normal of the tool's surface
/// by a force in proportion to its depth and to the surface that it stands for, limited as ContactScale says.
/// Friction is Coulomb's: along the surface a spring as stiff holds the node at its anchor, which slides
/// where the force would exceed the coefficient times the normal force. Nodes inside the body take part once
/// breaking has laid them open. A tool with a small mass has a softer contact, so that the time step stays
/// stable.
///
/// A tool that does not touch the body's nodes, but comes closer to one than a twentieth of the spacing,
/// touches that one: its surface is offset by the gap.
///
/// In motion a tool with a mass moves by the position Verlet scheme: over a step it goes on at its velocity,
/// then it takes over the impulse of the step; likewise it turns, by RigidTurning. In equilibrium its
/// position, or that of any tool with a force, is an unknown along the axes of the force.
class ToolTerm final : public Term {
public:
  /// Collective. The references must outlive the object.
  /// @param at_rest of each tool; receives what equilibria find
  /// @throws parallel::AgreedError on every rank when a tool overlaps the body at the start, or when a force
  ///   drives it in equilibria and it does not touch
  ToolTerm(const MotionContext& context, const std::vector<input::Tool>& tools,
           std::vector<ToolAtRest>& at_rest, std::int32_t nodes_per_block);

  void start(double time, const MotionState& state) override;
  bool acts_on(std::size_t block) const override {
    return must_find_ || first_contact_[block] < first_contact_[block + 1];
  }
  bool acts_elsewhere() override { return std::exchange(has_new_contacts_, false); }
  void before_kick(std::size_t block, const Substep& substep, MovingNodes& nodes) override;
  void after_kick(std::size_t block, const Substep& substep, MovingNodes& nodes) override;
  void end_step(const mechanics::StepSpan& step, MovingNodes& nodes, const Drives& drives) override;

  void add_supplied(double time, const MotionState& state, std::vector<double>& sum) const override;
  void add_dissipated(std::vector<double>& sum) const override;
  void add_stored(const parallel::NodeField& displacement, std::vector<double>& sum) const override;
  bool dissipates() const override;
  bool stores() const override { return true; }
  Demand demand(double from, double to) const override;

  bool is_linear() const override { return false; }
  void add_unit_loads(std::vector<UnitLoad>& loads) const override;
  void add_responses(double time, std::span<const double> displacement,
                     std::vector<NodeResponse>& responses) const override;
  std::vector<double*> unknowns() override;
  void add_unknown_responses(double time, std::span<const double> displacement,
                             std::vector<UnknownResponse>& responses) const override;
  /// The stable step is fitted to ContactScale.
  void add_stiffest(std::span<const double>, std::vector<NodeResponse>&) const override {}
  void add_supports(std::vector<mechanics::Support>& supports) const override;
  void rest_at(double time, const parallel::NodeField& displacement) override;
  void measure(double time, const parallel::NodeField& displacement, const parallel::NodeField* velocity,
               LoadState& state) const override;

  std::vector<parallel::NumberedRows> save() const override;
  void restore(const std::vector<parallel::NumberedRows>& rows) override;

private:
  /// Where a tool is.
  struct Pose {
    Vector displacement{};
    std::optional<Eigen::Quaterniond> orientation = {};  ///< of a tool that turns
    Vector out(const Vector& of_tool) const { return orientation ? turned(*orientation, of_tool) : of_tool; }
    Vector in(const Vector& of_space) const {
      return orientation ? turned(orientation->conjugate(), of_space) : of_space;
    }
  };
  /// How a node is inside a tool, in the tool's frame.
  struct Touch {
    double depth = 0;  ///< negative outside [m]
    Vector normal{};
    Vector relative{};  ///< displacement of the node from the tool [m]
    /// The way along the surface from another such displacement.
    Vector from(const Vector& other) const {
      const Vector way = relative - other;
      return way - dot(way, normal) * normal;
    }
  };
  /// A node near a tool, in motion.
  struct Contact {
    std::int32_t node = 0;
    std::size_t tool = 0;
    std::array<double, 3> remainder{};            // of MovingNodes::kick
    Vector velocity{};                            // before the kick [m/s]
    Vector impulse{}, moment{};                   // on the body in this step [N s], [N m s]
    double work = 0;                              // of the tool on the node [J]
    double taken = 0;                             // by the force along the surface [J]
    double held = 0;                              // of that in the spring now [J]
    std::optional<Vector> anchor = {};            // as Touch::relative [m]
    double lost() const { return taken - held; }  // by friction
    std::pair<std::int32_t, std::size_t> place() const { return {node, tool}; }
    bool has_touched() const {
      return work != 0 || taken != 0 || anchor || remainder != decltype(remainder){};
    }
  };
  struct Moving {
    std::array<mechanics::LoadCurve, 3> curve;  // of what is prescribed
    double offset = 0;                          // of the surface [m]
    double stiffness_share = 1;                 // of that of contact with a heavy tool
    double friction = 0;
    Vector displacement{}, velocity{};    // at time_, of one that moves by forces
    std::optional<RigidTurning> turning;  // of one that can turn, in motion
    double work = 0;                      // on the body, of one with a mass [J]
    std::map<std::int32_t, double> lost;  // by friction in equilibria, by node [J]
  };

  /// The axes along which a tool's position is an unknown of equilibria.
  bool is_unknown(std::size_t tool, std::size_t axis) const {
    return (*tools_)[tool].force && !moving_[tool].curve[axis].is_zero();
  }
  /// How contact at a node resists, and by which force, also along components that a motion prescribes.
  NodeResponse response(std::size_t tool, std::int32_t node, const Touch& touch) const;
  Pose pose_at(std::size_t tool, double time) const;
  Vector velocity_at(std::size_t tool, double time, const mechanics::StepSpan* step) const;
  /// Its largest part by turning [m/s].
  double turning_speed(std::size_t tool) const;
  /// From the middle of a tool in its place to a node [m].
  Vector arm(std::size_t tool, std::int32_t node, const Vector& displacement, const Pose& pose) const;
  Touch touch(std::size_t tool, std::int32_t node, const Vector& displacement, const Pose& pose) const;
  /// Stiffness of contact [N/m].
  double stiffness(std::size_t tool, std::int32_t node) const {
    return moving_[tool].stiffness_share * stiffness_[index(node)];
  }
  /// Force on the node in the tool's frame, with friction if it has an anchor [N].
  Vector force(std::size_t tool, std::int32_t node, const Touch& touch, const Vector* anchor) const;
  /// The stretch of the spring along the surface, at most as the friction allows [m].
  Vector stretch(std::size_t tool, const Touch& touch, const Vector& anchor) const;
  /// Lets the anchor slide.
  void slide(std::size_t tool, const Touch& touch, Vector& anchor) const;
  /// Calls visit(tool, node, touch) for all owned nodes inside a tool, or closer than `gap`.
  template <class Visit>
  void for_touches(double time, std::span<const double> displacement, double gap, const Visit& visit) const;
  const Vector* anchor_of(std::size_t tool, std::int32_t node) const;
  void soften_light_tools();  // collective
  void find_offsets();
  /// Finds all nodes to which a tool is closer than the margin [m].
  void find_contacts(double time, const MovingNodes& nodes, double margin);
  /// Lets tools with a mass take over the impulse of a step. Collective. @return the largest speed [m/s]
  double move_tools(const mechanics::StepSpan& step);
  /// Lets go of the anchors of nodes that are no longer inside a tool; others slide.
  void settle_anchors(const MovingNodes& nodes);
  /// A motion prescribes this component.
  bool is_driven(std::int32_t node, int component) const {
    return (driven_[index(node)] >> component & 1) != 0;
  }

  MotionContext context_;
  const std::vector<input::Tool>* tools_;
  std::vector<ToolAtRest>* at_rest_;
  std::int32_t nodes_per_block_;
  std::vector<std::uint8_t> driven_;  // per owned node: bits of components that a motion prescribes
  std::vector<double> stiffness_;     // of contact of each owned node with a heavy tool [N/m]
  double spacing_ = 0;                // mean one of the body [m]
  std::vector<Moving> moving_;
  double time_ = 0;
  bool is_moving_ = false;  // in a dynamic phase

  std::vector<Contact> contacts_;           // by node, then by tool
  std::vector<std::size_t> first_contact_;  // of each block, and their number
  bool must_find_ = true;                   // contacts_, before the first kick
  bool has_new_contacts_ = false;
  double room_ = 0;  // by which node and tool may approach before a node outside contacts_ is touched [m]
  std::vector<Vector> moved_;
};

/// Makes the terms of a sample's phases. @param tools must outlive them
MakeTerm make_tools(const std::vector<input::Tool>& tools);

}  // namespace crackle::dynamics
