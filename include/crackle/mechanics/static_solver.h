// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/subdomain.h"
#include "crackle/mechanics/internal_force.h"
#include "crackle/parallel/communicator.h"
#include "crackle/parallel/node_field.h"
#include "crackle/parallel/petsc.h"

#include <cstdint>
#include <functional>
#include <span>
#include <stdexcept>
#include <vector>

namespace crackle::mechanics {

/// The static problem has no solution that the solver can find, as when a loaded part has come loose.
class NoEquilibrium : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Which displacement components are prescribed; ghost nodes included.
using HeldComponents = std::vector<std::uint8_t>;  ///< 3 n_local, 1 where prescribed

/// Static equilibrium K u = f of the unbroken body: PETSc's conjugate gradients with algebraic multigrid
/// (GAMG) and the rigid-body modes as near null space. The preconditioner is kept over breaks until it wears
/// out.
class StaticSolver {
public:
  /// Assembles the intact body's matrix. Collective. The references must outlive the object.
  StaticSolver(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
               const PdsOperators& operators, const IsotropicElasticity& elasticity,
               const InternalForce& force, HeldComponents held);

  /// Takes tetrahedra out of the matrix, after they were released in the internal force. Collective; every
  /// rank names the local tetrahedra it holds.
  void release(std::span<const std::int32_t> tetrahedra);

  /// Solves for the free displacements; held components of `displacement` are given and kept.
  /// On entry `displacement` is the initial guess; ghosts are up to date on return. Collective.
  /// @param force 3 n_owned nodal forces [N]
  /// @return number of iterations
  /// @throws NoEquilibrium on every rank
  int solve(std::span<const double> force, parallel::NodeField& displacement);

private:
  void insert_rows(std::span<const std::int32_t> nodes);
  int run_solver(double reference_norm);

  const parallel::Communicator* group_;
  const geometry::Subdomain* subdomain_;
  const PdsOperators* operators_;
  IsotropicElasticity elasticity_;
  const InternalForce* force_;
  HeldComponents held_;
  NodeTetrahedra round_node_;
  std::vector<std::uint8_t> broken_;
  double typical_stiffness_ = 0;
  parallel::MatOwner matrix_;
  parallel::NullSpaceOwner rigid_modes_;
  parallel::KspOwner ksp_;
  parallel::NodeField residual_;
  parallel::NodeField correction_;
  int fresh_iterations_ = 0;  // of the first solve with the current preconditioner
};

}  // namespace crackle::mechanics
