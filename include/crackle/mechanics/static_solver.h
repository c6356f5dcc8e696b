// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"
#include "crackle/geometry/subdomain.h"
#include "crackle/mechanics/edges.h"
#include "crackle/mechanics/elasticity.h"
#include "crackle/mechanics/operators.h"
#include "crackle/parallel/communicator.h"
#include "crackle/parallel/node_field.h"

#include <cstdint>
#include <memory>
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

/// When the conjugate gradients get no further, what is left is the rounding of their product: more of it
/// where long thin parts move far under little load. Up to this, relative to the loads, that is an
/// equilibrium.
inline constexpr double rounding_allowance = 1e-6;

/// What counts as an equilibrium: a residual, in the norm that the preconditioner defines, below both bounds.
struct Accuracy {
  double of_loads = 1e-10;  ///< over the residual of the body whose free components have not moved
  /// Over the energy norm of the displacement, near its relative error in that norm. Prescribed motions
  /// that strain one layer of the mesh have a large residual at first, and a little of that can be much.
  double of_displacement = infinity;
};

/// Static equilibrium K u = f: conjugate gradients without a matrix. The product is the fast edge loop in
/// single precision, the preconditioner a block Jacobi and a coarse correction by rigid motions of cells; now
/// and then the residual is computed anew in double precision.
///
/// Every sum is independent of its order, so the solution has the same bits for every partition.
class StaticSolver {
public:
  /// Collective. The references must outlive the object.
  /// @param residual_stiffness may change, see release()
  StaticSolver(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
               const PdsOperators& operators, const IsotropicElasticity& elasticity, const Edges& edges,
               const ResidualStiffness& residual_stiffness, HeldComponents held);
  ~StaticSolver();
  StaticSolver(const StaticSolver&) = delete;
  StaticSolver& operator=(const StaticSolver&) = delete;

  /// Takes over that tetrahedra carry less. Local; every rank names the local tetrahedra it holds.
  void release(std::span<const std::int32_t> tetrahedra);

  /// Solves for the free displacements; held components of `displacement` are given and kept.
  /// On entry `displacement` is the initial guess; ghosts are up to date on return, also after an exception,
  /// which leaves the last iterate. Collective.
  /// @param force 3 n_owned nodal forces [N]
  /// @return number of iterations
  /// @throws NoEquilibrium on every rank
  int solve(std::span<const double> force, parallel::NodeField& displacement, const Accuracy& accuracy = {});

  /// What is left of the out-of-balance force after the last solve, over that of the body whose free
  /// components have not moved; both in the preconditioner's norm. Computed from the displacement, not
  /// carried along.
  double residual() const;

private:
  class Problem;
  std::unique_ptr<Problem> problem_;
};

}  // namespace crackle::mechanics
