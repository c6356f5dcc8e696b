// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/mechanics/operators.h"
#include "crackle/mechanics/residual_stiffness.h"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace crackle::mechanics {

/// The internal force of a body with its broken set: displacement in, force out.
///
/// An implementation must give every owned node the same bits for every partition. Not collective: ghost
/// displacements must be up to date.
class InternalForce {
public:
  virtual ~InternalForce() = default;

  /// force_a = sum over tetrahedra of V sigma b^a, with the stress that they still carry.
  /// @param displacement 3 n_local values [m]
  /// @param force 3 n_local values, valid for owned nodes [N]
  virtual void evaluate(std::span<const double> displacement, std::span<double> force) const = 0;
};

/// The definition: a plain loop over tetrahedra in ascending order, in double precision.
class ReferenceForce final : public InternalForce {
public:
  /// The references must outlive the object; what the tetrahedra carry may change.
  ReferenceForce(const PdsOperators& operators, const ResidualStiffness& residual_stiffness)
      : operators_(&operators), residual_stiffness_(&residual_stiffness) {}
  void evaluate(std::span<const double> displacement, std::span<double> force) const override;

private:
  const PdsOperators* operators_;
  const ResidualStiffness* residual_stiffness_;
};

}  // namespace crackle::mechanics
