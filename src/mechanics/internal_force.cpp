// SPDX-License-Identifier: GPL-3.0-or-later
#include "mechanics/internal_force.h"

#include "common/index.h"

#include <algorithm>

namespace crackle::mechanics {

void InternalForce::evaluate(std::span<const double> displacement, std::span<double> force) const {
  std::ranges::fill(force, 0.0);
  for (std::size_t number = 0; number < operators_->tetrahedra.size(); ++number)
    add(static_cast<std::int32_t>(number), displacement, force);
}

void InternalForce::evaluate(std::span<const std::int32_t> tetrahedra, std::span<const double> displacement,
                             std::span<double> force) const {
  std::ranges::fill(force, 0.0);
  for (const auto tetrahedron : tetrahedra) add(tetrahedron, displacement, force);
}

void InternalForce::evaluate_strains(std::span<const Symmetric> strain, std::span<double> force) const {
  std::ranges::fill(force, 0.0);
  for (std::size_t t = 0; t < strain.size(); ++t)
    if (const auto number = static_cast<std::int32_t>(t); carries(number))
      add_strain(number, operators_->tetrahedra[t], strain[t], force);
}

bool InternalForce::carries(std::int32_t tetrahedron) const {
  return residual_stiffness_->carries(tetrahedron) || residual_stiffness_->has_contact(tetrahedron);
}

void InternalForce::add(std::int32_t tetrahedron, std::span<const double> displacement,
                        std::span<double> force) const {
  if (!carries(tetrahedron)) return;
  const TetrahedronOperator t = operators_->tetrahedra[index(tetrahedron)];
  const Symmetric total = strain(t, displacement);
  add_strain(tetrahedron, t,
             initial_strain_ != nullptr ? initial_strain_->elastic(tetrahedron, total) : total, force);
}

void InternalForce::add_strain(std::int32_t tetrahedron, const TetrahedronOperator& t,
                               const Symmetric& strain, std::span<double> force) const {
  const Symmetric sigma = residual_stiffness_->stress(tetrahedron, strain);
  for (std::size_t a = 0; a < 4; ++a) {
    const Vector traction = apply(sigma, t.gradient[a]);
    double* f = &force[3 * index(t.nodes[a])];
    for (std::size_t i = 0; i < 3; ++i) f[i] += t.volume * traction[i];
  }
}

}  // namespace crackle::mechanics
