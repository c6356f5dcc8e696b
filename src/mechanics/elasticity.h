// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/model.h"
#include "mechanics/tensor.h"
#include "mechanics/tetrahedron_field.h"

#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace crackle::mechanics {

/// Isotropic linear elasticity: sigma = lambda tr(eps) I + 2 mu eps.
struct IsotropicElasticity {
  double lambda = 0;  ///< [Pa]
  double mu = 0;      ///< [Pa]

  IsotropicElasticity() = default;
  IsotropicElasticity(double youngs_modulus, double poisson_ratio)
      : lambda(youngs_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))),
        mu(youngs_modulus / (2 * (1 + poisson_ratio))) {}
  explicit IsotropicElasticity(const input::Material& material)
      : IsotropicElasticity(material.youngs_modulus, material.poisson_ratio) {}

  bool operator==(const IsotropicElasticity&) const = default;

  double youngs_modulus() const { return mu * (3 * lambda + 2 * mu) / (lambda + mu); }  ///< [Pa]
  double bulk_modulus() const { return lambda + 2 * mu / 3; }                           ///< [Pa]

  Symmetric operator()(const Symmetric& eps) const {
    const double pressure = lambda * (eps[0] + eps[1] + eps[2]);
    return {pressure + 2 * mu * eps[0],
            pressure + 2 * mu * eps[1],
            pressure + 2 * mu * eps[2],
            2 * mu * eps[3],
            2 * mu * eps[4],
            2 * mu * eps[5]};
  }
};

/// The material of each tetrahedron of a subdomain, as far as its motion depends on it.
struct MaterialField {
  TetrahedronField<IsotropicElasticity> elasticity;
  TetrahedronField<double> density;  ///< [kg/m^3]

  explicit MaterialField(const input::Material& material)
      : elasticity(IsotropicElasticity(material)), density(material.density) {}
  MaterialField(TetrahedronField<IsotropicElasticity> elastic, TetrahedronField<double> mass_density)
      : elasticity(std::move(elastic)), density(std::move(mass_density)) {}
};
using ElasticityField = TetrahedronField<IsotropicElasticity>;

/// The field of several materials.
/// @param number of the material of each tetrahedron; empty: the only one
MaterialField material_field(const std::vector<input::Material>& materials,
                             std::span<const std::uint8_t> number);

/// Speed of plane dilatational waves in an unbounded body [m/s].
inline double dilatational_speed(const IsotropicElasticity& elasticity, double density) {
  return std::sqrt((elasticity.lambda + 2 * elasticity.mu) / density);
}
inline double dilatational_speed(const input::Material& material) {
  return dilatational_speed(IsotropicElasticity(material), material.density);
}

/// Speed of longitudinal waves in thin bars [m/s].
inline double bar_speed(const IsotropicElasticity& elasticity, double density) {
  return std::sqrt(elasticity.youngs_modulus() / density);
}

/// Speed of plane shear waves [m/s].
inline double shear_speed(const IsotropicElasticity& elasticity, double density) {
  return std::sqrt(elasticity.mu / density);
}
inline double shear_speed(const input::Material& material) {
  return shear_speed(IsotropicElasticity(material), material.density);
}

/// Speed of Rayleigh waves [m/s].
inline double rayleigh_speed(const IsotropicElasticity& elasticity, double density) {
  // Squared ratio of the shear and the pressure wave speed.
  const double ratio = elasticity.mu / (elasticity.lambda + 2 * elasticity.mu);
  const auto excess = [&](double c) {
    return (2 - c * c) * (2 - c * c) - 4 * std::sqrt(1 - c * c) * std::sqrt(1 - ratio * c * c);
  };
  double lower = 0.3, upper = 1;  // in shear speeds; for every Poisson ratio from -1 to 0.5
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (lower + upper);
    (excess(middle) < 0 ? lower : upper) = middle;
  }
  return lower * shear_speed(elasticity, density);
}
inline double rayleigh_speed(const input::Material& material) {
  return rayleigh_speed(IsotropicElasticity(material), material.density);
}

}  // namespace crackle::mechanics
