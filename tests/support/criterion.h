// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/fracture/tuler_butcher.h"
#include "crackle/geometry/subdomain.h"

namespace crackle::test {

/// Tuler-Butcher with uniform strength from the input.
inline fracture::TulerButcher tuler_butcher(const input::Fracture& parameters,
                                            const geometry::Subdomain& subdomain, double time_step = 5e-9) {
  return {parameters, parameters.impulse,
          std::vector<double>(subdomain.tetrahedra.size(), parameters.strength), time_step};
}

/// A criterion by which nothing breaks.
inline fracture::TulerButcher unbreakable(const geometry::Subdomain& subdomain, double strength = 1e15) {
  return tuler_butcher({.strength = strength, .exponent = 2, .impulse = 1e4}, subdomain);
}

}  // namespace crackle::test
