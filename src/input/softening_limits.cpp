// SPDX-License-Identifier: GPL-3.0-or-later
#include "input/softening_limits.h"

#include "common/real.h"

#include <algorithm>

namespace crackle::input {

namespace {

/// The least of a length over the materials.
template <class Length>
double least_of(const Model& model, const Length& length) {
  double least = infinity;
  for (std::size_t i = 0; i < model.materials.size(); ++i)
    least = std::min(least, length(model.materials[i], model.fracture_of(i)));
  return least;
}

double zone_length(const Material& material, const Fracture& fracture) {
  return material.youngs_modulus * fracture.toughness / (fracture.strength * fracture.strength);
}

}  // namespace

double process_zone_length(const Model& model) {
  return least_of(model, zone_length);
}

double snap_back_spacing(const Model& model) {
  return least_of(model, [](const Material& material, const Fracture& fracture) {
    const double nu = material.poisson_ratio;
    const double stored =
        std::max(0.5, (1 + nu) * (1 - 2 * nu));  // stored energy density, relative to strength^2 / E
    // Minimum ratio of the energy dissipated by softening to that stored at the strength, such that stress
    // falls no faster than strain.
    const double least_ductility = fracture.softening == SofteningCurve::linear ? 1 : 2;
    return zone_length(material, fracture) / (least_ductility * stored * spacings_per_band);
  });
}

}  // namespace crackle::input
