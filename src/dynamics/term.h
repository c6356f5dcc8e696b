// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "common/vector.h"
#include "dynamics/energy_account.h"
#include "dynamics/integrator.h"
#include "mechanics/conditions.h"
#include "mechanics/node_stiffness.h"
#include "parallel/communicator.h"
#include "parallel/node_field.h"
#include "parallel/numbered_rows.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace crackle::dynamics {

/// The state of a moving body.
struct MotionState {
  parallel::NodeField displacement;  ///< [m]
  parallel::NodeField velocity;      ///< [m/s]
};

/// The owned nodes of a moving body as a Term sees them: in SI units, but in the numbers of the
/// implementation, to which changes are rounded. Of ghosts the displacement, once they are current.
class MovingNodes {
public:
  virtual ~MovingNodes() = default;

  virtual double displacement(std::int32_t node, int component) const = 0;  ///< [m]
  virtual Vector whole_displacement(std::int32_t node) const {              ///< [m]
    return {displacement(node, 0), displacement(node, 1), displacement(node, 2)};
  }
  virtual double velocity(std::int32_t node, int component) const = 0;  ///< [m/s]
  /// The internal force, by which the velocity changes with the opposite sign [N].
  virtual double internal_force(std::int32_t node, int component) const = 0;

  /// Changes the velocity by a force that acts for a duration.
  /// @param remainder rounding error carried over from one kick to the next, 0 at first, in units of the
  ///   implementation: without it a constant force would be rounded the same way in every kick
  virtual void kick(std::int32_t node, int component, double duration, double force, double& remainder) = 0;
  /// Changes the velocity, and the displacement by the change times `duration`.
  /// @return the change as rounded [m/s]
  virtual double change_velocity(std::int32_t node, int component, double change, double duration) = 0;
  virtual void set_velocity(std::int32_t node, int component, double velocity) = 0;
  /// Puts a node at a displacement after a drift.
  virtual void drive(std::int32_t node, int component, double displacement, double velocity,
                     double drift) = 0;

  /// Adds forces on nodes, which end with the next evaluation of the internal force: rounded, so that the
  /// first node balances the others exactly.
  /// @param nodes -1: of another rank, which does the same @param forces [N], of the first node not read
  virtual void add_balanced_forces(std::span<const std::int32_t> nodes, std::span<const Vector> forces) = 0;

  /// How far each local node, ghosts included, has moved in the last step [m].
  virtual void movements(std::span<Vector> moved) const = 0;
  /// Sums of forces are independent of the partition if each is a multiple of this [N]; 0: no matter.
  virtual double force_quantum() const = 0;
};

/// The demands of a term on the numbers of a phase, at most; 0: none. Equal on every rank.
struct Demand {
  double stress = 0;        ///< that its forces cause where they act [Pa]
  double velocity = 0;      ///< that it prescribes [m/s]
  double acceleration = 0;  ///< that it gives a fragment, whatever that is supported by [m/s^2]
  double resultant = 0;     ///< of its forces on the body [N]
  bool holds = false;       ///< supports the body

  Demand& operator+=(const Demand& other);
};

/// A part of the loads on a body at rest that follows a curve.
struct UnitLoad {
  /// The first three are superposed in this order. Others are of terms that are not linear, which only tell
  /// when they change.
  enum class Kind { force, motion, strain, other };
  Kind kind = Kind::force;
  const mechanics::LoadCurve* curve = nullptr;
  /// Turns zeros, 3 n_local, into the nodal forces at factor 1 [N], or the displacements of a motion [m]; at
  /// owned nodes.
  std::function<void(std::span<double>)> apply = {};
  double total = 0;  ///< of the magnitudes of a force pattern's forces at factor 1, over all ranks [N]
  bool is_integrated = false;  ///< the factor is the curve's integral from time 0

  bool is_force() const { return kind == Kind::force || kind == Kind::strain; }
  double factor(double time) const { return is_integrated ? curve->integral(time) : curve->at(time); }
  /// From this time on.
  double rate(double time) const { return is_integrated ? curve->at(time) : curve->slope(time); }
  bool grows_after(double time) const {
    return curve->slope(time) != 0 || curve->next_kink(time) < infinity || (is_integrated && rate(time) != 0);
  }
};

/// The response of a term at an owned node of a body at rest.
struct NodeResponse : mechanics::NodeStiffness {  ///< by which the force falls with the displacement [N/m]
  Vector force{};                                 ///< on the body [N]
};

/// The balance of an unknown of a term at rest.
struct UnknownResponse {
  double force = 0;      ///< unbalanced: of its load and of the body on it; equal on every rank [N]
  double load = 0;       ///< its load alone [N]
  double stiffness = 0;  ///< by which the force falls with the unknown; equal on every rank [N/m]
  /// Forces on owned nodes per unknown [N/m].
  std::vector<std::pair<std::int32_t, Vector>> coupling = {};
};

/// A contribution to the equation of motion besides the stiffness of the body. An object serves one dynamic
/// phase, or the equilibria of a sample; nodes are the owned ones of this rank, in consecutive blocks. Local
/// unless stated otherwise. It leaves out components that a motion prescribes: it would act on the drive.
///
/// In each stage of a step the hooks of all terms are called block by block, term by term: before and after
/// the kick by the internal force, and after the drift. In equilibrium, a linear term has loads that factors
/// of time scale, and a constant stiffness; with any other, loads grow in increments.
class Term {
public:
  virtual ~Term() = default;

  /// Writes what is prescribed at a time into the owned part of the state.
  virtual void prescribe([[maybe_unused]] double time, [[maybe_unused]] MotionState& state) const {}
  /// The phase starts; called once.
  /// @param state as the implementation holds it, with what is prescribed
  virtual void start([[maybe_unused]] double time, [[maybe_unused]] const MotionState& state) {}

  /// True if it acts on nodes of a block in a kick, or prescribes them.
  virtual bool acts_on([[maybe_unused]] std::size_t block) const { return false; }
  /// True if what acts_on() says has changed since the last call. Asked after each step.
  virtual bool acts_elsewhere() { return false; }
  virtual void before_kick(std::size_t, const Substep&, MovingNodes&) {}
  virtual void after_kick(std::size_t, const Substep&, MovingNodes&) {}
  virtual void after_drift(std::size_t, const Substep&, MovingNodes&) {}

  /// True if it has forces between nodes in the coming step, added by add_forces(); equal on every rank.
  virtual bool couples_nodes() const { return false; }
  /// The internal force at the current displacement has been found, and ghosts are current. Collective.
  virtual void add_forces(MovingNodes&) {}

  /// A force against which the driven component of a node moves: gets the displacement over the step [m], and
  /// returns the force [N].
  using Resistance = std::function<double(std::int32_t node, int component, double displacement)>;
  /// Calls a resistance for all components that any term drives.
  using Drives = std::function<void(const Resistance&)>;
  /// A step ends, once ghosts are current. Collective.
  virtual void end_step(const mechanics::StepSpan&, MovingNodes&, const Drives&) {}
  /// Calls `resistance` for all components that this term drives, and does the work.
  virtual void move_against(const mechanics::StepSpan&, const Resistance&) {}

  /// Adds the addends of its energies since the start of the phase [J]: of this rank, in any order.
  virtual void add_supplied([[maybe_unused]] double time, [[maybe_unused]] const MotionState& state,
                            [[maybe_unused]] std::vector<double>& sum) const {}
  virtual void add_dissipated([[maybe_unused]] std::vector<double>& sum) const {}
  /// The energy that it stores now, such as that of a spring [J].
  virtual void add_stored([[maybe_unused]] const parallel::NodeField& displacement,
                          [[maybe_unused]] std::vector<double>& sum) const {}
  /// Adds what it stores in motion only, so that it is lost when the body comes to rest [J].
  virtual void add_lost_at_rest([[maybe_unused]] const parallel::NodeField& displacement,
                                [[maybe_unused]] std::vector<double>& sum) const {}
  /// True if it may do so; equal on every rank.
  virtual bool dissipates() const { return false; }
  virtual bool stores() const { return false; }

  /// Loads are about to end at these nodes; the work done so far is kept.
  virtual void end_loads([[maybe_unused]] double time,
                         [[maybe_unused]] const mechanics::NodesOfConditions& nodes,
                         [[maybe_unused]] const parallel::NodeField& displacement) {}

  /// Between two times of the load curves [s]. Collective.
  virtual Demand demand([[maybe_unused]] double from, [[maybe_unused]] double to) const { return {}; }

  /// False if its response to a displacement is not linear; equal on every rank.
  virtual bool is_linear() const { return true; }
  virtual void add_unit_loads([[maybe_unused]] std::vector<UnitLoad>& loads) const {}
  /// Marks the displacement components that it prescribes with 1. @param held 3 n_owned or more
  virtual void mark_held([[maybe_unused]] std::span<std::uint8_t> held) const {}
  /// Adds its response at the nodes where it acts. That of a linear term is a stiffness, the same at any time
  /// and displacement.
  /// @param displacement of a body at rest, 3 n_local
  virtual void add_responses([[maybe_unused]] double time,
                             [[maybe_unused]] std::span<const double> displacement,
                             [[maybe_unused]] std::vector<NodeResponse>& responses) const {}
  /// Displacements that are found with those of the body, such as that of a tool under a force; equal on
  /// every rank [m].
  virtual std::vector<double*> unknowns() { return {}; }
  /// Adds the balance of each. Collective.
  virtual void add_unknown_responses([[maybe_unused]] double time,
                                     [[maybe_unused]] std::span<const double> displacement,
                                     [[maybe_unused]] std::vector<UnknownResponse>& responses) const {}
  /// Adds the largest stiffness that it may ever have, to which the time step is fitted; that of responses if
  /// it is linear.
  virtual void add_stiffest(std::span<const double> no_displacement, std::vector<NodeResponse>& most) const {
    add_responses(0, no_displacement, most);
  }
  /// Where it can hold the body in place.
  virtual void add_supports([[maybe_unused]] std::vector<mechanics::Support>& supports) const {}
  /// The body has come to rest: the equilibria that follow, and the energies, refer to this one.
  virtual void rest_at([[maybe_unused]] double time,
                       [[maybe_unused]] const parallel::NodeField& displacement) {}
  /// Adds its loads at a time, the works that they do, and what else is to be recorded, always the same
  /// quantities: equal on every rank. Collective.
  /// @param velocity of a moving body; nullptr at rest
  virtual void measure([[maybe_unused]] double time, [[maybe_unused]] const parallel::NodeField& displacement,
                       [[maybe_unused]] const parallel::NodeField* velocity,
                       [[maybe_unused]] LoadState& state) const {}

  /// The state that restore() needs, gathered on the root. Collective.
  virtual std::vector<parallel::NumberedRows> save() const { return {}; }
  /// @throws std::runtime_error when the rows are those of another term
  virtual void restore([[maybe_unused]] const std::vector<parallel::NumberedRows>& rows) {}
};

}  // namespace crackle::dynamics
