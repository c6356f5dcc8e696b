// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/mechanics/elasticity.h"
#include "crackle/mechanics/operators.h"

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

  /// force_a = sum over unbroken tetrahedra of V sigma b^a.
  /// @param displacement 3 n_local values [m]
  /// @param force 3 n_local values, valid for owned nodes [N]
  virtual void evaluate(std::span<const double> displacement, std::span<double> force) const = 0;

  /// Opens all six dual facets of a tetrahedron: it carries nothing from now on.
  virtual void release(std::int32_t tetrahedron) = 0;
};

/// The definition: a plain loop over tetrahedra in ascending order, in double precision.
class ReferenceForce final : public InternalForce {
public:
  /// @param operators must outlive the object
  ReferenceForce(const PdsOperators& operators, const IsotropicElasticity& elasticity);
  void evaluate(std::span<const double> displacement, std::span<double> force) const override;
  void release(std::int32_t tetrahedron) override;

private:
  const PdsOperators* operators_;
  IsotropicElasticity elasticity_;
  std::vector<std::int32_t> intact_;  // tetrahedra that still carry, ascending
};

}  // namespace crackle::mechanics
