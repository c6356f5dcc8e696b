// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/parallel/communicator.h"
#include "crackle/parallel/petsc.h"

#include <span>

namespace crackle::parallel {

/// Dot product that does not depend on the order of the terms, nor on the ranks they lie on: every product is
/// split into two integers on scales that follow from the largest product of all ranks, and integers are
/// summed. Its error is below 2^-70 n times the largest product. Far cheaper than ExactSum. Collective.
/// @pre below 2^26 terms in all
/// @return NaN when a product is NaN, else infinity when one is infinite
double reproducible_dot(MPI_Comm communicator, std::span<const double> a, std::span<const double> b);

/// Conjugate gradients over a PETSc matrix and preconditioner, with reproducible_dot(): as KSPCG with the
/// natural norm computes, but with the same bits for every partition where matrix and preconditioner have
/// that.
class ConjugateGradients {
public:
  /// @param like a vector of the unknowns; its duplicates hold what the iterations need. Collective.
  explicit ConjugateGradients(Vec like);

  struct Outcome {
    bool has_converged;
    int n_iterations;
  };

  /// Solves from zero until the norm of the residual r in the preconditioner's scalar product, sqrt(r . M^-1
  /// r), is at most `tolerance` or NaN, or the matrix turns out not to be positive definite.
  /// Allocates nothing. Collective; does not agree() before.
  /// @param residual the right-hand side on entry, what is left of it on return
  /// @throws std::runtime_error with PETSc's message
  Outcome solve(Mat matrix, PC preconditioner, Vec residual, Vec solution, double tolerance,
                int max_iterations);

private:
  VecOwner preconditioned_, direction_, image_;
};

}  // namespace crackle::parallel
