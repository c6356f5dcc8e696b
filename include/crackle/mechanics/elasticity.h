// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"
#include "crackle/mechanics/tensor.h"

namespace crackle::mechanics {

/// Isotropic linear elasticity: sigma = lambda tr(eps) I + 2 mu eps.
struct IsotropicElasticity {
  double lambda;  ///< [Pa]
  double mu;      ///< [Pa]

  explicit IsotropicElasticity(const input::Material& material)
      : lambda(material.youngs_modulus * material.poisson_ratio /
               ((1 + material.poisson_ratio) * (1 - 2 * material.poisson_ratio))),
        mu(material.youngs_modulus / (2 * (1 + material.poisson_ratio))) {}

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

}  // namespace crackle::mechanics
