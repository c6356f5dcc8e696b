// SPDX-License-Identifier: GPL-3.0-or-later
#include "mechanics/elasticity.h"

namespace crackle::mechanics {

MaterialField material_field(const std::vector<input::Material>& materials,
                             std::span<const std::uint8_t> number) {
  if (number.empty()) return MaterialField(materials.front());
  std::vector<IsotropicElasticity> elasticity;
  std::vector<double> density;
  for (const std::uint8_t m : number) {
    elasticity.emplace_back(materials[m]);
    density.push_back(materials[m].density);
  }
  return {ElasticityField(std::move(elasticity)), TetrahedronField<double>(std::move(density))};
}

}  // namespace crackle::mechanics
