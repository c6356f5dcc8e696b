// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/input/softening_limits.h"

#include <algorithm>

namespace crackle::input {

double process_zone_length(const Parameters& parameters) {
  const Fracture& fracture = parameters.fracture;
  return parameters.material().youngs_modulus * fracture.toughness / (fracture.strength * fracture.strength);
}

double snap_back_spacing(const Parameters& parameters) {
  const double nu = parameters.material().poisson_ratio;
  const double stored =
      std::max(0.5, (1 + nu) * (1 - 2 * nu));  // stored energy density, relative to strength^2 / E
  // Minimum ratio of the energy dissipated by softening to that stored at the strength, such that stress
  // falls no faster than strain.
  const double least_ductility = parameters.fracture.softening == SofteningCurve::linear ? 1 : 2;
  return process_zone_length(parameters) / (least_ductility * stored * spacings_per_band);
}

}  // namespace crackle::input
