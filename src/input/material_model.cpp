// SPDX-License-Identifier: GPL-3.0-or-later
#include "input/material_model.h"

namespace crackle::input {

MaterialModel::MaterialModel(const Model& model)
    : seed(model.seed),
      materials(model.materials),
      fracture(model.fracture),
      interfaces(model.interfaces),
      maps_stiffness(model.maps_stiffness()),
      maps_strength(model.maps_strength()),
      initial_stresses(model.initial_stresses),
      bounds(bounds_of(model.specimen)) {
  for (std::size_t m = 0; m < materials.size(); ++m) of_material.push_back(model.fracture_of(m));
}

}  // namespace crackle::input
