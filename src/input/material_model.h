// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/model.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace crackle::input {

/// What the input says on the materials of a body: stiffness, density, stress from the start, how they break
/// and how they vary. All that the fracture of a sample depends on, but for its mesh and its loads.
struct MaterialModel {
  MaterialModel(const Model& model);

  std::uint64_t seed;                 ///< of random fields
  std::vector<Material> materials;    ///< the first one fills the body outside the regions
  Fracture fracture;                  ///< [fracture] as it stands in the input
  std::vector<Fracture> of_material;  ///< [fracture] as it applies to each material
  std::vector<Interface> interfaces;
  bool maps_stiffness, maps_strength;
  std::vector<InitialStress> initial_stresses;
  plane::Region bounds;  ///< of the body, along which these change

  /// The material of a uniform body; in others the one outside the regions.
  const Material& material() const { return materials.front(); }
  /// [fracture] as it applies to a material.
  const Fracture& fracture_of(std::size_t number) const { return of_material[number]; }
};

}  // namespace crackle::input
