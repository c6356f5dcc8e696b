// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/initial_strain.h"

#include "common/index.h"
#include "geometry/point.h"

#include <cmath>
#include <span>
#include <utility>

namespace crackle::fracture {

namespace {

using mechanics::Symmetric;

/// Mean of the input's value over a tetrahedron, exact if the value is linear there, or the parabola: so that
/// what balances still does on the mesh.
double mean_value(const input::InitialStress& initial, const std::pair<double, double>& extent,
                  std::span<const geometry::Point> nodes, const geometry::Tetrahedron& corners) {
  const std::size_t axis = index(initial.along);
  const double centre = geometry::centroid(nodes, corners)[axis];
  double value = input::value_at(initial, extent, centre);
  if (initial.kind != input::InitialStressKind::surface) return value;
  double squares = 0;
  for (const auto node : corners) squares += std::pow((nodes[index(node)][axis] - centre), 2);
  return value + 6 * initial.surface * squares / (20 * std::pow(extent.second - extent.first, 2));
}

/// The strain whose elastic stress has these normal components.
Symmetric strain_of(const Vector& normal_stress, const mechanics::IsotropicElasticity& elasticity) {
  const auto [lambda, mu] = elasticity;
  const double trace = normal_stress[0] + normal_stress[1] + normal_stress[2];
  const double volumetric = lambda / (3 * lambda + 2 * mu) * trace;
  Symmetric strain{};
  for (std::size_t i = 0; i < 3; ++i) strain[i] = (normal_stress[i] - volumetric) / (2 * mu);
  return strain;
}

/// @param value of the input's table at the tetrahedron: stress, or change of temperature
Symmetric free_strain(const input::InitialStress& initial, double value,
                      const mechanics::IsotropicElasticity& elasticity) {
  if (initial.kind == input::InitialStressKind::temperature) {
    const double expansion = initial.expansion * value;
    return {expansion, expansion, expansion, 0, 0, 0};
  }
  Vector opposite{};
  for (int i = 0; i < 3; ++i) opposite[index(i)] = initial.has(i) ? -value : 0;
  return strain_of(opposite, elasticity);
}

}  // namespace

mechanics::InitialStrain make_initial_strain(const input::MaterialModel& model,
                                             const mechanics::ElasticityField& elasticity,
                                             const TetrahedronSpan& tetrahedra) {
  const auto n = static_cast<std::int32_t>(tetrahedra.tetrahedra.size());
  std::vector<mechanics::InitialStrain::Part> parts;
  for (const input::InitialStress& initial : model.initial_stresses) {
    const auto extent = model.bounds[index(initial.along)];
    mechanics::InitialStrain::Part& part = parts.emplace_back(mechanics::InitialStrain::Part{
        mechanics::LoadCurve(1, 0, initial.history), std::vector<Symmetric>(index(n))});
    for (std::int32_t t = 0; t < n; ++t) {
      const std::size_t material = tetrahedra.material_of(index(t));
      if (!initial.material.empty() && initial.material != model.materials[material].name) continue;
      part.strain[index(t)] =
          free_strain(initial, mean_value(initial, extent, tetrahedra.nodes, tetrahedra.tetrahedra[index(t)]),
                      elasticity[t]);
    }
  }
  return parts.empty() ? mechanics::InitialStrain() : mechanics::InitialStrain(std::move(parts), n);
}

std::vector<Symmetric> initial_strain_at(const input::MaterialModel& model, double time,
                                         const mechanics::ElasticityField& elasticity,
                                         const TetrahedronSpan& tetrahedra) {
  mechanics::InitialStrain strain = make_initial_strain(model, elasticity, tetrahedra);
  if (strain.is_none()) return {};
  strain.set_time(time);
  std::vector<Symmetric> values;
  for (std::int32_t t = 0; t < static_cast<std::int32_t>(tetrahedra.tetrahedra.size()); ++t)
    values.push_back(strain[t]);
  return values;
}

}  // namespace crackle::fracture
