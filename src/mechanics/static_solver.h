// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "geometry/subdomain.h"
#include "mechanics/edges.h"
#include "mechanics/elasticity.h"
#include "mechanics/node_stiffness.h"
#include "mechanics/operators.h"
#include "parallel/communicator.h"
#include "parallel/node_field.h"

#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

namespace crackle::mechanics {

/// The solver cannot find a static equilibrium, for example because a loaded part has come loose.
class NoEquilibrium : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Flags of prescribed displacement components, including ghost nodes.
using HeldComponents = std::vector<std::uint8_t>;  ///< 3 n_local, 1 where prescribed

/// When conjugate gradients stagnate, the remaining residual is due to rounding of the product, which is
/// larger for slender parts with large displacements under small loads. A residual up to this value, relative
/// to the loads, is accepted as an equilibrium.
inline constexpr double rounding_allowance = 1e-6;

/// Convergence criterion: a residual, in the norm defined by the preconditioner, below both bounds.
struct Accuracy {
  double of_loads = 1e-8;  ///< relative to the residual with no free component displaced
  /// Relative to the energy norm of the displacement; approximates the relative error in that norm.
  /// Prescribed motions that strain a single layer of the mesh have a large initial residual, of which even a
  /// small fraction can be significant.
  double of_displacement = infinity;
};

/// Static equilibrium K u = f by matrix-free conjugate gradients. The product is the fast edge loop in single
/// precision; the preconditioner combines block Jacobi with a coarse correction by rigid motions of cells;
/// the residual is periodically recomputed in double precision.
///
/// All sums are independent of the order, so the solution is bitwise equal for every partition; that of
/// PETSc's solvers is not, and their matrix product takes four times as long (tests/benchmark).
class StaticSolver {
public:
  /// Collective. The references must outlive the object.
  /// @param residual_stiffness may change, see release()
  StaticSolver(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
               const PdsOperators& operators, const ElasticityField& elasticity, const Edges& edges,
               const ResidualStiffness& residual_stiffness, HeldComponents constrained);
  ~StaticSolver();
  StaticSolver(const StaticSolver&) = delete;
  StaticSolver& operator=(const StaticSolver&) = delete;

  /// Updates the stiffness of tetrahedra that carry less load. Local; every rank names the local tetrahedra
  /// it holds.
  void release(std::span<const std::int32_t> tetrahedra);

  /// Replaces the stiffness that holds nodes besides the body's own; none at first. Collective.
  /// @param nodes at most one entry per owned node, ascending
  void set_node_stiffness(std::span<const NodeStiffness> nodes);

  /// Frees most of the memory until the next solve, which computes the coefficients again. Local.
  void rest();

  /// Solves for the free displacements; constrained components of `displacement` are prescribed. On entry
  /// `displacement` is the initial guess; on return ghosts are up to date. After an exception it contains the
  /// last iterate. Collective.
  /// @param force 3 n_owned nodal forces [N]
  /// @return number of iterations
  /// @throws NoEquilibrium on every rank
  int solve(std::span<const double> force, parallel::NodeField& displacement, const Accuracy& accuracy = {});

  /// Relative residual of the last solve, with respect to that with no free component displaced; both in the
  /// preconditioner's norm. Computed from the displacement, not from the recurrence.
  double residual() const;

private:
  class Problem;
  std::unique_ptr<Problem> problem_;
};

}  // namespace crackle::mechanics
