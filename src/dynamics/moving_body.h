// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/instruction_set.h"
#include "dynamics/checkpoint.h"
#include "dynamics/contact_stiffness.h"
#include "dynamics/integrator.h"
#include "dynamics/sample_result.h"
#include "dynamics/term.h"
#include "fracture/breakable_body.h"
#include "fracture/fracture_law.h"
#include "mechanics/conditions.h"
#include "parallel/communicator.h"
#include "parallel/node_field.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace crackle::dynamics {

/// A body in explicit dynamics: displacement and velocity in the number format of the implementation, and the
/// internal force for the current set of broken tetrahedra. One object serves one dynamic phase.
///
/// Except for PETSc's, every implementation gives results at owned nodes that are bitwise independent of the
/// partition.
class MovingBody {
public:
  virtual ~MovingBody() = default;

  /// The stages of one step of the splitting. With mass damping or an absorbing face the splitting must be
  /// Verlet, as others have backward substeps. Collective; a rank throws only after its communication is
  /// complete.
  /// @param time of the load curves at the beginning of the step [s]
  virtual void step(std::span<const Stage> stages, double time_step, double time) = 0;

  /// The local unbroken tetrahedra now above the screening share of their strength, ascending. Local.
  virtual std::span<const std::int32_t> overloaded() = 0;

  /// Current elastic strain of a local tetrahedron. Local.
  virtual mechanics::Symmetric strain(std::int32_t tetrahedron) const = 0;

  /// Strain of a local tetrahedron at the start of the last step() or of the one before. Before its first
  /// step the body counts as being at rest. Local.
  /// @param n_steps 1 or 2
  virtual mechanics::Symmetric strain_before(std::int32_t tetrahedron, int n_steps) const = 0;

  /// Displacements of local nodes relative to the first of them, now or `n_steps` before, as above [m].
  /// Local.
  /// @param n_steps 0, 1 or 2
  virtual void relative_displacements(std::span<const std::int32_t> nodes, int n_steps,
                                      std::span<Vector> result) const = 0;

  /// Updates the stiffness of tetrahedra that have broken or lost part of their stiffness. Local.
  virtual void release(std::span<const std::int32_t> tetrahedra) = 0;

  /// Takes over strengths of the law that have changed. Local.
  virtual void update_strengths([[maybe_unused]] std::span<const std::int32_t> tetrahedra) {}

  /// Copies the state: displacements with ghosts, velocities of owned nodes. Local.
  virtual void read(MotionState& state) const = 0;

  /// Strain energy, with what the terms store [J]. Collective; bitwise equal for any number of ranks if the
  /// state is.
  /// @param state as currently returned by read()
  virtual double strain_energy(const MotionState& state) const = 0;

  /// Work of the loads since the start [J]. Collective.
  /// @param state as currently returned by read()
  virtual double external_work(double time, const MotionState& state) const = 0;

  /// Announces that loads are about to end at these nodes; the work done so far is kept. Local.
  /// @param state as currently returned by read()
  virtual void end_loads(double time, const mechanics::NodesOfConditions& nodes,
                         const MotionState& state) = 0;

  /// Dissipated by the terms since the start [J]. Collective.
  virtual double dissipated_energy() const { return 0; }
  /// Energy that terms store in motion only [J]. Collective.
  /// @param state as currently returned by read()
  virtual double energy_lost_at_rest([[maybe_unused]] const MotionState& state) const { return 0; }

  /// The loads, and what else the terms measure. Collective; bitwise equal for any number of ranks if the
  /// state is.
  /// @param state as currently returned by read()
  virtual LoadState measure([[maybe_unused]] double time, [[maybe_unused]] const MotionState& state) const {
    return {};
  }

  /// Why the state on this rank is no longer valid, for example a number out of range; empty if it is valid.
  virtual std::optional<std::string> failure() const { return {}; }

  /// Owned nodes whose numbers are about to leave their range, unless they are frozen. Local.
  virtual std::vector<std::int32_t> leaving() const { return {}; }
  /// Holds nodes where they are, free of force, from now on; the kinetic energy that they lose counts as
  /// dissipated. Local.
  /// @param nodes local nodes, ghosts too: whole pieces of the body
  /// @param energy of the nodes of all ranks [J]
  virtual void freeze([[maybe_unused]] std::span<const std::int32_t> nodes, [[maybe_unused]] double energy) {}
  /// 1 for each local node that is frozen; empty: none.
  virtual std::span<const std::uint8_t> frozen() const { return {}; }
  virtual double frozen_energy() const { return 0; }  ///< taken from all ranks' nodes [J]

  /// Data for restore() to continue from here, on the root. Collective.
  virtual MotionCheckpoint save() const = 0;

  /// Continues from the saved state of an identically constructed body; the tetrahedra broken up to then must
  /// have been released. The continuation is bitwise the same as without interruption. Local.
  /// @throws std::runtime_error when the checkpoint lacks a node
  virtual void restore(const MotionCheckpoint& checkpoint) = 0;

  virtual std::int64_t n_forces() const = 0;  ///< evaluations of the internal force so far

  /// Communication of ghost displacements so far.
  virtual ExchangeCost exchange_cost() const { return {}; }
};

struct MotionContext;

/// Makes a term for one dynamic phase, from the state at its start, or for the equilibria of a sample, from
/// that without displacements. Collective.
/// @param context without a law while the set-up asks for stiffness and supports
/// @param nodes_per_block of the implementation
using MakeTerm = std::function<std::unique_ptr<Term>(const MotionContext& context, const MotionState& given,
                                                     std::int32_t nodes_per_block)>;

/// Context shared by the dynamic phases of one sample.
struct MotionContext {
  const parallel::Communicator* group;
  fracture::BreakableBody* body;
  const mechanics::Conditions* loads;
  fracture::FractureLaw* law;
  double damping_rate = 0;  ///< of mass-proportional damping: force / (mass * velocity) [1/s]
  /// Stiffness or initial strain may differ between tetrahedra.
  bool material_varies = false;
  input::BulkViscosity bulk_viscosity = {};
  std::vector<MakeTerm> more_terms = {};  ///< beside the conditions and the damping
  ContactScale contact = {};              ///< of surfaces that meet
};

/// The reference implementation: all operations in double precision, in sequence, with the plain loop over
/// tetrahedra (mechanics::InternalForce). Collective.
/// @param state at the start; updated in place, so it must outlive the motion
std::unique_ptr<MovingBody> make_reference_motion(const MotionContext& context, double load_time,
                                                  MotionState& state);

/// The fast implementation: fixed-point numbers of 32 bits (mixed) or 64 bits (double), edge-based, with
/// force, kick and drift fused and the breaking check screened by bounds. Collective.
/// @param duration maximum duration of the phase [s]; determines the range of the numbers
/// @param state at the start; prescribed components are set to their values at load_time
std::unique_ptr<MovingBody> make_fixed_point_motion(const MotionContext& context, input::Precision precision,
                                                    double load_time, double duration, MotionState& state,
                                                    InstructionSet instruction_set = best_instruction_set());

/// As the reference, but with PETSc's matrix-vector product (mechanics::PetscStiffness), which is not bitwise
/// independent of the partition. Collective.
/// @pre no contact
std::unique_ptr<MovingBody> make_petsc_motion(const MotionContext& context, double load_time,
                                              MotionState& state);

/// The implementation selected by the input's engine. Collective.
/// @param duration as for make_fixed_point_motion()
std::unique_ptr<MovingBody> make_motion(const MotionContext& context, const input::Time& parameters,
                                        double load_time, double duration, MotionState& state);

}  // namespace crackle::dynamics
