// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/mechanics/internal_force.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace crackle::mechanics {

ReferenceForce::ReferenceForce(const PdsOperators& operators, const IsotropicElasticity& elasticity)
    : operators_(&operators), elasticity_(elasticity), intact_(operators.tetrahedra.size()) {
  std::iota(intact_.begin(), intact_.end(), 0);
}

void ReferenceForce::evaluate(std::span<const double> displacement, std::span<double> force) const {
  std::ranges::fill(force, 0.0);
  for (const auto index : intact_) {
    const auto& t = operators_->tetrahedra[static_cast<std::size_t>(index)];
    const Symmetric sigma = elasticity_(strain(t, displacement));
    for (std::size_t a = 0; a < 4; ++a) {
      const Vector traction = apply(sigma, t.gradient[a]);
      double* f = &force[3 * static_cast<std::size_t>(t.nodes[a])];
      for (std::size_t i = 0; i < 3; ++i) f[i] += t.volume * traction[i];
    }
  }
}

void ReferenceForce::release(std::int32_t tetrahedron) {
  const auto place = std::ranges::lower_bound(intact_, tetrahedron);
  if (place == intact_.end() || *place != tetrahedron) {
    throw std::logic_error("internal force: a tetrahedron was released twice");
  }
  intact_.erase(place);
}

}  // namespace crackle::mechanics
