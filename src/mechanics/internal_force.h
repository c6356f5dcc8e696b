// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mechanics/initial_strain.h"
#include "mechanics/operators.h"
#include "mechanics/residual_stiffness.h"

#include <cstdint>
#include <span>

namespace crackle::mechanics {

/// The internal force of a body with its broken tetrahedra, by definition: a plain loop over tetrahedra in
/// ascending order, in double precision. Forces at owned nodes are bitwise independent of the partition. Not
/// collective: ghost displacements must be up to date.
class InternalForce {
public:
  /// The references must outlive the object; the residual stiffness and the initial strain may change.
  /// @param initial_strain nullptr: none, so that the force is linear in the displacement
  InternalForce(const PdsOperators& operators, const ResidualStiffness& residual_stiffness,
                const InitialStrain* initial_strain = nullptr)
      : operators_(&operators), residual_stiffness_(&residual_stiffness), initial_strain_(initial_strain) {}

  /// force_a = sum over tetrahedra of V sigma b^a, with the stress sigma that they still carry.
  /// @param displacement 3 n_local values [m]
  /// @param force 3 n_local values, valid for owned nodes [N]
  void evaluate(std::span<const double> displacement, std::span<double> force) const;

  /// The same for some tetrahedra: nodes touched by no others get the same bits as from evaluate().
  /// @param tetrahedra local numbers, ascending
  void evaluate(std::span<const std::int32_t> tetrahedra, std::span<const double> displacement,
                std::span<double> force) const;

  /// The same for given strains of all local tetrahedra, elastic and of whatever origin.
  void evaluate_strains(std::span<const Symmetric> strain, std::span<double> force) const;

private:
  void add(std::int32_t tetrahedron, std::span<const double> displacement, std::span<double> force) const;
  void add_strain(std::int32_t tetrahedron, const TetrahedronOperator& t, const Symmetric& strain,
                  std::span<double> force) const;
  bool carries(std::int32_t tetrahedron) const;

  const PdsOperators* operators_;
  const ResidualStiffness* residual_stiffness_;
  const InitialStrain* initial_strain_;
};

}  // namespace crackle::mechanics
