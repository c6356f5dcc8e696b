// SPDX-License-Identifier: GPL-3.0-or-later
#include "input/material_model.h"

namespace crackle::input {

MaterialModel::MaterialModel(const Parameters& parameters)
    : seed(parameters.ensemble.seed),
      materials(parameters.materials),
      fracture(parameters.fracture),
      interfaces(parameters.interfaces),
      maps_stiffness(parameters.maps_stiffness()),
      maps_strength(parameters.maps_strength()),
      initial_stresses(parameters.initial_stresses),
      bounds(bounds_of(parameters.specimen)) {
  for (std::size_t m = 0; m < materials.size(); ++m) of_material.push_back(parameters.fracture_of(m));
}

}  // namespace crackle::input
