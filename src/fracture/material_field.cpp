// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/material_field.h"

#include "common/index.h"
#include "common/real.h"
#include "parallel/exact_sum.h"

#include <algorithm>

namespace crackle::fracture {

namespace {

/// Factors of each tetrahedron: by its material's variation and the input's raster.
struct Factors {
  std::vector<double> stiffness, density;
};

Factors factors_of(const input::MaterialModel& model, std::uint64_t sample,
                   const TetrahedronSpan& tetrahedra) {
  const std::size_t n = tetrahedra.tetrahedra.size();
  Factors factors{std::vector<double>(n, 1), std::vector<double>(n, 1)};
  for (std::size_t m = 0; m < model.materials.size(); ++m) {
    const auto& variation = model.materials[m].variation;
    if (!variation) continue;
    const auto own = stiffness_factors(model, m, sample, tetrahedra);
    for (std::size_t t = 0; t < n; ++t) {
      if (tetrahedra.material_of(t) != m) continue;
      if (variation->of != input::StiffnessVaries::density) factors.stiffness[t] = own[t];
      if (variation->of != input::StiffnessVaries::stiffness) factors.density[t] = own[t];
    }
  }
  if (model.maps_stiffness)
    for (std::size_t t = 0; t < n; ++t) factors.stiffness[t] *= static_cast<double>(tetrahedra.map_factor[t]);
  return factors;
}

}  // namespace

mechanics::MaterialField make_material_field(const input::MaterialModel& model, std::uint64_t sample,
                                             const TetrahedronSpan& tetrahedra) {
  const auto& materials = model.materials;
  const bool varies =
      std::ranges::any_of(materials, [](const auto& one) { return one.variation.has_value(); });
  if (!varies && !model.maps_stiffness) return mechanics::material_field(materials, tetrahedra.material);
  const Factors factors = factors_of(model, sample, tetrahedra);
  const std::size_t n = tetrahedra.tetrahedra.size();
  std::vector<mechanics::IsotropicElasticity> elasticity;
  std::vector<double> density;
  elasticity.reserve(n);
  density.reserve(n);
  for (std::size_t t = 0; t < n; ++t) {
    const input::Material& material = materials[tetrahedra.material_of(t)];
    elasticity.emplace_back(factors.stiffness[t] * material.youngs_modulus, material.poisson_ratio);
    density.push_back(factors.density[t] * material.density);
  }
  return {mechanics::ElasticityField(std::move(elasticity)),
          mechanics::TetrahedronField<double>(std::move(density))};
}

BodyWaves slowest_waves(const parallel::Communicator& group, const input::MaterialModel& model,
                        const BreakableBody& body) {
  const auto& [elasticity, density] = body.material();
  const TetrahedronSpan tetrahedra = span_of(body.subdomain());
  struct Slowness {
    double bar, dilatational;
  };
  const auto slowness = [](const mechanics::IsotropicElasticity& stiffness, double mass) {
    return Slowness{1 / mechanics::bar_speed(stiffness, mass),
                    1 / mechanics::dilatational_speed(stiffness, mass)};
  };
  std::vector<Slowness> of_input;
  for (const input::Material& material : model.materials)
    of_input.push_back(slowness(mechanics::IsotropicElasticity(material), material.density));
  // Deviations from the input's values, so that these come out exactly where nothing varies.
  std::vector<std::vector<double>> terms(3 * of_input.size());
  for (std::int32_t t = 0; t < body.subdomain().n_tetrahedra(); ++t) {
    if (body.subdomain().owned[index(t)] == 0) continue;
    const std::size_t m = tetrahedra.material_of(index(t));
    const double volume = body.operators().tetrahedra[index(t)].volume;
    const Slowness own = slowness(elasticity[t], density[t]);
    terms[3 * m].push_back(volume);
    terms[3 * m + 1].push_back(volume * (own.bar - of_input[m].bar));
    terms[3 * m + 2].push_back(volume * (own.dilatational - of_input[m].dilatational));
  }
  const auto sums = parallel::exact_sums(group, terms);
  BodyWaves slowest{infinity, infinity};
  for (std::size_t m = 0; m < of_input.size(); ++m) {
    const double volume = sums[3 * m];
    if (volume == 0) continue;
    slowest.bar = std::min(slowest.bar, 1 / (of_input[m].bar + sums[3 * m + 1] / volume));
    slowest.dilatational =
        std::min(slowest.dilatational, 1 / (of_input[m].dilatational + sums[3 * m + 2] / volume));
  }
  return slowest;
}

}  // namespace crackle::fracture
