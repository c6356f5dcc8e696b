// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/input/body_load.h"

#include "crackle/input/parameters.h"

#include <algorithm>
#include <iterator>

namespace crackle::input {

Vector BodyLoad::at(const Vector& p) const {
  const Vector arm = p - point;
  switch (kind) {
    case LoadKind::angular_velocity: {
      const Vector along = axis / norm(axis);
      return (angular_velocity * angular_velocity) * (arm - dot(arm, along) * along);
    }
    case LoadKind::velocity_gradient:
      return {dot(gradient[0], arm), dot(gradient[1], arm), dot(gradient[2], arm)};
    default:
      return value;
  }
}

std::vector<BodyLoad> Parameters::body_forces() const {
  std::vector<BodyLoad> forces;
  std::ranges::copy_if(loads, std::back_inserter(forces),
                       [](const BodyLoad& load) { return !is_initial(load.kind); });
  return forces;
}

std::vector<BodyLoad> Parameters::initial_velocities() const {
  std::vector<BodyLoad> velocities;
  std::ranges::copy_if(loads, std::back_inserter(velocities),
                       [](const BodyLoad& load) { return is_initial(load.kind); });
  return velocities;
}

}  // namespace crackle::input
