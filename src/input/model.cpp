// SPDX-License-Identifier: GPL-3.0-or-later
#include "input/model.h"

#include "common/interpolation.h"

#include <cmath>
#include <iterator>
#include <string_view>

namespace crackle::input {

using crackle::operator-;
using crackle::operator*;

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

std::vector<std::array<int, 2>> Model::interface_pairs() const {
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

Fracture Model::fracture_of(std::size_t number) const {
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

Vector BodyLoad::at(const Vector& p) const {
  const Vector arm = p - point;
  switch (kind) {
    case LoadKind::angular_velocity: {
      const Vector along = axis / norm(axis);
      return (angular_velocity * angular_velocity) * (arm - dot(arm, along) * along);
    }
    case LoadKind::velocity_gradient:
      return {dot(gradient[0], arm), dot(gradient[1], arm), dot(gradient[2], arm)};
    case LoadKind::acceleration:
    case LoadKind::body_force:
    case LoadKind::velocity:
      break;
  }
  return value;
}

std::vector<BodyLoad> Model::body_forces() const {
  std::vector<BodyLoad> forces;
  std::ranges::copy_if(loads, std::back_inserter(forces),
                       [](const BodyLoad& load) { return !is_initial(load.kind); });
  return forces;
}

std::vector<BodyLoad> Model::initial_velocities() const {
  std::vector<BodyLoad> velocities;
  std::ranges::copy_if(loads, std::back_inserter(velocities),
                       [](const BodyLoad& load) { return is_initial(load.kind); });
  return velocities;
}

double Profile::at(double coordinate) const {
  return interpolated(table, coordinate);
}

double Profile::largest_magnitude() const {
  double largest = 0;
  for (const auto& [coordinate, factor] : table) largest = std::max(largest, std::abs(factor));
  return largest;
}

}  // namespace crackle::input
