// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/common/real.h"
#include "crackle/input/parameters.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace crackle::input {

namespace {

/// Irwin's relation in plane strain [J/m^2].
double toughness_of(double intensity, const Material& material) {
  const double nu = material.poisson_ratio;
  return intensity * intensity * (1 - nu * nu) / material.youngs_modulus;
}

}  // namespace

int material_named(const std::vector<Material>& materials, const std::string& name) {
  const auto found = std::ranges::find(materials, name, &Material::name);
  return found == materials.end() ? -1 : static_cast<int>(found - materials.begin());
}

std::filesystem::path MaterialMap::path(std::uint64_t sample) const {
  std::string name = file;
  const std::string_view number = "{sample}";
  for (auto at = name.find(number); at != std::string::npos; at = name.find(number, at))
    name.replace(at, number.size(), std::to_string(sample));
  return folder / name;
}

std::vector<std::array<int, 2>> Parameters::interface_pairs() const {
  std::vector<std::array<int, 2>> pairs;
  for (const Interface& one : interfaces)
    pairs.push_back({material_named(materials, one.between[0]), material_named(materials, one.between[1])});
  return pairs;
}

double slowest_bar_speed(const std::vector<Material>& materials) {
  double slowest = infinity;
  for (const Material& material : materials)
    slowest = std::min(slowest, std::sqrt(material.youngs_modulus / material.density));
  return slowest;
}

Fracture Parameters::fracture_of(std::size_t number) const {
  const Material& material = materials[number];
  Fracture result = fracture;
  if (material.strength > 0) result.strength = material.strength;
  if (material.fracture_toughness > 0)
    result.toughness = toughness_of(material.fracture_toughness, material);
  else if (material.toughness > 0)
    result.toughness = material.toughness;
  else if (fracture.fracture_toughness > 0)
    result.toughness = toughness_of(fracture.fracture_toughness, material);
  if (material.impulse > 0) result.impulse = material.impulse;
  if (material.release_time || material.release_speed > 0) {
    result.release_time = material.release_time;
    result.release_speed = material.release_speed;
  }
  return result;
}

}  // namespace crackle::input
