// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fixed_point_force.h"
#include "parallel/communicator.h"

#include "kernels/cell_kernels.h"

#include <optional>
#include <span>

namespace crackle::mechanics {

/// K u by the fast edge loop, bitwise equal for every partition. The scale of the fixed-point numbers is
/// adapted from product to product to the operand's largest component and to the largest contribution of an
/// edge of the body, which do not depend on the partition.
///
/// @tparam Real double is as accurate as an explicit matrix; float rounds coefficients and differences of the
///   operand to 24 bits, and is several times faster
template <class Real>
class StiffnessProduct {
public:
  /// Collective. The references must outlive the object.
  StiffnessProduct(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                   const PdsOperators& operators, const ElasticityField& elasticity, const Edges& edges,
                   const ResidualStiffness& residual_stiffness);

  /// @param displacement 3 n_local, ghosts up to date
  /// @param force of the owned nodes, 3 n_owned [N]
  /// @return displacement . force of all ranks, of the displacement as the format rounds it [N m]
  /// Collective. @pre not at rest
  /// @throws std::runtime_error on every rank when the operand is not finite
  double apply(std::span<const Real> displacement, std::span<Real> force);

  /// Updates the coefficients after tetrahedra have broken. Local.
  void update(std::span<const std::int32_t> tetrahedra) {
    if (force_) force_->update(tetrahedra, false);
  }

  /// Frees the coefficients, which are most of the memory. Local.
  void rest() { force_.reset(); }
  /// Computes them again, with the current stiffness, if they have been freed. Local.
  void resume();

private:
  /// To the nodes, in quanta of 1 / scale; the forces become 0.
  void set_displacements(std::span<const Real> displacement, double scale);
  /// From the nodes, in quanta. @return displacement . force, in quanta
  __int128 get_forces(double quantum, std::span<Real> force);

  const parallel::Communicator* group_;
  const geometry::Subdomain* subdomain_;
  const PdsOperators* operators_;
  const ElasticityField* elasticity_;
  const Edges* edges_;
  const ResidualStiffness* residual_stiffness_;
  double unit_ = 0;  // force quantum per displacement quantum [N/m]
  std::optional<FixedPointForce<Real>> force_;
  const kernels::CellKernels* cell_kernels_;
  // Exponent of largest contribution over largest displacement in the last product; empty if unknown.
  std::optional<int> gain_exponent_;
};

}  // namespace crackle::mechanics
