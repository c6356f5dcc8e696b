// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/fracture/material_field.h"

#include <algorithm>

namespace crackle::fracture {

namespace {

/// Factors of one kind of each tetrahedron: those of its material.
std::vector<double> factors_of(const input::Parameters& parameters, std::uint64_t sample,
                               const TetrahedronSpan& tetrahedra, input::StiffnessVaries without) {
  std::vector<double> factors(tetrahedra.tetrahedra.size(), 1);
  for (std::size_t m = 0; m < parameters.materials.size(); ++m) {
    const auto& variation = parameters.materials[m].variation;
    if (!variation || variation->of == without) continue;
    const auto own = stiffness_factors(parameters, m, sample, tetrahedra);
    for (std::size_t t = 0; t < factors.size(); ++t)
      if (tetrahedra.material_of(t) == m) factors[t] = own[t];
  }
  return factors;
}

}  // namespace

mechanics::MaterialField make_material_field(const input::Parameters& parameters, std::uint64_t sample,
                                             const TetrahedronSpan& tetrahedra) {
  const auto& materials = parameters.materials;
  const bool varies =
      std::ranges::any_of(materials, [](const auto& one) { return one.variation.has_value(); });
  if (materials.size() == 1 && !varies && !parameters.maps_stiffness())
    return mechanics::MaterialField(materials.front());
  auto stiffness = factors_of(parameters, sample, tetrahedra, input::StiffnessVaries::density);
  const auto weight = factors_of(parameters, sample, tetrahedra, input::StiffnessVaries::stiffness);
  if (parameters.maps_stiffness())
    for (std::size_t t = 0; t < stiffness.size(); ++t)
      stiffness[t] *= static_cast<double>(tetrahedra.map_factor[t]);
  std::vector<mechanics::IsotropicElasticity> elasticity;
  std::vector<double> density;
  elasticity.reserve(stiffness.size());
  density.reserve(stiffness.size());
  for (std::size_t t = 0; t < stiffness.size(); ++t) {
    const input::Material& material = materials[tetrahedra.material_of(t)];
    elasticity.emplace_back(stiffness[t] * material.youngs_modulus, material.poisson_ratio);
    density.push_back(weight[t] * material.density);
  }
  return {mechanics::ElasticityField(std::move(elasticity)),
          mechanics::TetrahedronField<double>(std::move(density))};
}

mechanics::TetrahedronField<double> fracture_field(const input::Parameters& parameters,
                                                   const TetrahedronSpan& tetrahedra,
                                                   double input::Fracture::*key) {
  std::vector<double> of_material;
  for (std::size_t m = 0; m < parameters.materials.size(); ++m)
    of_material.push_back(parameters.fracture_of(m).*key);
  if (tetrahedra.material.empty()) return mechanics::TetrahedronField<double>(of_material.front());
  std::vector<double> values;
  values.reserve(tetrahedra.tetrahedra.size());
  for (std::size_t t = 0; t < tetrahedra.tetrahedra.size(); ++t)
    values.push_back(of_material[tetrahedra.material_of(t)]);
  return mechanics::TetrahedronField<double>(std::move(values));
}

}  // namespace crackle::fracture
