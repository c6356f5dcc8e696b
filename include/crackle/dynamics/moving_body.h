// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/instruction_set.h"
#include "crackle/dynamics/checkpoint.h"
#include "crackle/dynamics/integrator.h"
#include "crackle/dynamics/sample_result.h"
#include "crackle/fracture/breakable_body.h"
#include "crackle/fracture/criterion.h"
#include "crackle/fracture/stress_average.h"
#include "crackle/mechanics/boundary_loads.h"
#include "crackle/parallel/communicator.h"
#include "crackle/parallel/node_field.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace crackle::dynamics {

/// The state of a moving body.
struct MotionState {
  parallel::NodeField displacement;  ///< [m]
  parallel::NodeField velocity;      ///< [m/s]
};

/// A body in explicit dynamics: displacement and velocity in the number format of the implementation, and the
/// internal force that goes with its broken set. One object lasts for one dynamic phase.
///
/// Every implementation but PETSc's gives owned nodes the same bits for every partition.
class MovingBody {
public:
  virtual ~MovingBody() = default;

  /// The stages of one step of the splitting; those of Verlet where there is damping or an absorbing face, as
  /// others have substeps backward in time. Collective; what it throws on one rank, it throws when its
  /// messages are complete.
  /// @param time of the load curves at the beginning of the step [s]
  virtual void step(std::span<const Stage> stages, double time_step, double time) = 0;

  /// The local tetrahedra above the watched share of their strength now, ascending, and among them only
  /// unbroken ones. Local.
  virtual std::span<const std::int32_t> overloaded() = 0;

  /// Strain of a local tetrahedron now. Local.
  virtual mechanics::Symmetric strain(std::int32_t tetrahedron) const = 0;

  /// Strain of a local tetrahedron at the start of the last step() or of the one before. The body is taken to
  /// have rested before its first step. Local.
  /// @param n_steps 1 or 2
  virtual mechanics::Symmetric strain_before(std::int32_t tetrahedron, int n_steps) const = 0;

  /// Takes over that broken tetrahedra of the body carry less from now on. Local.
  virtual void release(std::span<const std::int32_t> tetrahedra) = 0;

  /// Copies the state: displacements with ghosts, velocities of owned nodes. Local.
  virtual void read(MotionState& state) const = 0;

  /// Work of the loads since the start [J]. Collective.
  /// @param state as read() gives it now
  virtual double external_work(double time, const MotionState& state) const = 0;

  /// Takes over that loads are about to end at these nodes; their work up to now stays. Local.
  /// @param state as read() gives it now
  virtual void end_loads(double time, const mechanics::NodesOfConditions& nodes,
                         const MotionState& state) = 0;

  /// Taken out by damping and by absorbing faces since the start [J]. Collective.
  virtual double dissipated_energy() const { return 0; }

  /// Why the state can no longer be trusted on this rank, as when a number outgrew its format; or empty.
  virtual std::optional<std::string> failure() const { return {}; }

  /// What restore() needs to continue from here, on the root. Collective.
  virtual MotionCheckpoint save() const = 0;

  /// Goes on from where a body that was made alike was saved; the tetrahedra that it broke up to there have
  /// been released. Every later bit is as if there had been no interruption. Local.
  /// @throws std::runtime_error when the checkpoint lacks a node
  virtual void restore(const MotionCheckpoint& checkpoint) = 0;

  virtual std::int64_t n_forces() const = 0;  ///< evaluations of the internal force so far

  /// Exchanges of ghost displacements so far.
  virtual ExchangeCost exchange_cost() const { return {}; }
};

/// What the dynamic phases of one sample share.
struct MotionContext {
  const parallel::Communicator* group;
  fracture::BreakableBody* body;
  const mechanics::BoundaryLoads* loads;
  double density;  ///< [kg/m^3]
  fracture::Criterion* criterion;
  double screening_share = 1;  ///< of the strength: MovingBody::overloaded() tells what is above it
  fracture::StressAverage* average =
      nullptr;              ///< what the criterion sees instead of a tetrahedron's own stress
  double damping_rate = 0;  ///< of mass-proportional damping: force over mass and velocity [1/s]
};

/// The definition: every operation in double precision, one after the other, with the plain loop over
/// tetrahedra (mechanics::InternalForce). Collective.
/// @param state at the start; the motion goes on in it, so it must outlive the motion
std::unique_ptr<MovingBody> make_reference_motion(const MotionContext& context, double load_time,
                                                  MotionState& state);

/// The fast path: fixed-point numbers of 32 bits (mixed) or 64 bits (double), edge by edge, force, kick and
/// drift fused, the breaking check by bounds. Collective.
/// @param duration of the phase at most [s]; the range of the numbers follows from it
/// @param state at the start; prescribed components are set to their values at load_time
std::unique_ptr<MovingBody> make_fixed_point_motion(const MotionContext& context, input::Precision precision,
                                                    double load_time, double duration, MotionState& state,
                                                    InstructionSet instruction_set = best_instruction_set());

/// As the definition, but with PETSc's product (mechanics::PetscStiffness), whose bits depend on the
/// partition. Collective.
/// @pre no contact
std::unique_ptr<MovingBody> make_petsc_motion(const MotionContext& context, double load_time,
                                              MotionState& state);

/// That of the input's engine. Collective.
/// @param duration as for make_fixed_point_motion()
std::unique_ptr<MovingBody> make_motion(const MotionContext& context, const input::Time& parameters,
                                        double load_time, double duration, MotionState& state);

}  // namespace crackle::dynamics
