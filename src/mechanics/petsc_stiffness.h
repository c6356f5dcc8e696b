// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/subdomain.h"
#include "mechanics/elasticity.h"
#include "mechanics/operators.h"
#include "mechanics/residual_stiffness.h"
#include "parallel/communicator.h"
#include "parallel/node_field.h"
#include "parallel/petsc.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::mechanics {

/// The stiffness of a body as PETSc's symmetric block matrix, with blocks of three; rows belong to the ranks
/// that own the nodes. Contact is not included.
///
/// PETSc sums in the order of its columns, so products are not bitwise independent of the partition.
class PetscStiffness {
public:
  /// Assembles the matrix. Collective; agrees before its messages. The references must outlive the object.
  PetscStiffness(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                 const PdsOperators& operators, const ElasticityField& elasticity,
                 const ResidualStiffness& residual_stiffness);

  /// force = K displacement, for owned nodes [N]. Collective; does not call check_peers() before.
  /// @param displacement owned values; ghosts are not read [m]
  /// @throws std::runtime_error with PETSc's message
  void apply(parallel::NodeField& displacement, parallel::NodeField& force) const;

  /// Recomputes the rows of nodes whose tetrahedra lost stiffness, bitwise as in a newly assembled matrix.
  /// Local; assemble() must follow before the next product.
  void update(std::span<const std::int32_t> tetrahedra);

  /// Completes the updates of all ranks. Collective; does not call check_peers() before.
  void assemble();

private:
  void find_columns(std::int32_t node);
  void set_row(std::int32_t node);

  const PdsOperators* operators_;
  const ElasticityField* elasticity_;
  const ResidualStiffness* residual_stiffness_;
  std::int32_t n_owned_;
  std::vector<PetscInt> number_;  // per local node, in the order of the matrix
  NodeTetrahedra node_to_cell_;
  parallel::MatOwner matrix_;
  // The current row: block columns from the diagonal on, and their values row by row.
  std::vector<PetscInt> columns_;
  std::vector<double> values_;
};

}  // namespace crackle::mechanics
