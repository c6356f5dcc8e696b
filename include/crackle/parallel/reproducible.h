// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/parallel/communicator.h"
#include "crackle/parallel/petsc.h"

#include <cstdint>
#include <span>

namespace crackle::parallel {

/// Dot product that does not depend on the order of the terms, nor on the ranks they lie on: every product is
/// split into two integers on scales that follow from the largest product of all ranks, and integers are
/// summed. Its error is below 2^-70 n times the largest product. Far cheaper than ExactSum. Collective.
/// @pre below 2^26 terms in all
/// @return NaN when a product is NaN, else infinity when one is infinite
double reproducible_dot(MPI_Comm communicator, std::span<const double> a, std::span<const double> b);

/// Replaces the operations of a PETSc vector that a Krylov method uses by ones whose result has the same bits
/// for every partition: dot products and norms by reproducible_dot(), updates by plain loops (BLAS may fuse
/// operations differently at the ends of an array). Vectors duplicated from it inherit them. A failure in one
/// ends in PETSc's error code.
void make_reproducible(Vec vector);

}  // namespace crackle::parallel
