// SPDX-License-Identifier: GPL-3.0-or-later
#include "condition_loads.h"

#include "common/index.h"
#include "mechanics/elasticity.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include "loaded_region.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

namespace crackle::mechanics {

namespace {

using input::BoundaryKind;

/// Least resultant of a total force whose factor changes sign, relative to the sum of magnitudes.
constexpr double least_resultant = 1e-9;

constexpr const char* is_zero_in_region = "is 0 in its whole region";

void refuse_empty(const ConditionOnMesh& place, bool is_empty, const char* part) {
  if (!is_empty) return;
  throw parallel::AgreedError(
      0, fmt::format("boundary[{}] on {}: its region contains no {} of the mesh; enlarge "
                     "the region or refine the mesh",
                     place.number, place.condition.on, part));
}

LoadCurve curve(const input::Boundary& condition, int component) {
  return {condition.value[index(component)], condition.rate[index(component)], condition.history};
}

void refuse_factor(const ConditionOnMesh& place, bool is_refused, const char* reason) {
  if (!is_refused) return;
  throw parallel::AgreedError(
      0, fmt::format("boundary[{}] on {}: its factor {}", place.number, place.condition.on, reason));
}

/// Shares of the loaded area or length.
ConditionNodes area_shares(LoadedRegion region) {
  for (double& area : region.area) area = std::abs(area) / region.total_area;
  return {std::move(region.nodes), std::move(region.area)};
}

/// A force, or a traction with the same vector everywhere.
void add_vector_load(const ConditionOnMesh& place, Conditions& loads) {
  const auto& factor = place.condition.factor;
  LoadedRegion region = loaded_region(place.group, place.region, place.subdomain, factor);
  refuse_factor(place, factor && region.total_area == 0, is_zero_in_region);
  refuse_empty(place, region.total_area == 0, "boundary triangle");
  const bool is_total = place.condition.kind == BoundaryKind::force;
  // A total cannot be kept by a distribution without resultant.
  refuse_factor(
      place, is_total && std::abs(region.resultant) <= least_resultant * region.total_area,
      "adds up to nothing over its region, so that it cannot distribute a total force; give a traction");
  for (int component = 0; component < 3; ++component) {
    LoadCurve amplitude = curve(place.condition, component);
    if (amplitude.is_zero()) continue;
    ForcePattern pattern{component,         std::move(amplitude), region.nodes, region.area,
                         region.total_area, region.resultant,     place.number};
    if (is_total) {
      for (auto& weight : pattern.weight) weight /= region.resultant;
      pattern.total_weight = region.total_area / std::abs(region.resultant);
      pattern.resultant = 1;
    }
    loads.forces.push_back(std::move(pattern));
  }
  loads.conditions.push_back(area_shares(std::move(region)));
}

void add_pressure(const ConditionOnMesh& place, Conditions& loads) {
  const auto& factor = place.condition.factor;
  LoadedRegion region = loaded_region(place.group, place.region, place.subdomain, factor);
  refuse_factor(place, factor && region.total_area == 0, is_zero_in_region);
  double total_area = 0;
  for (int component = 0; component < 3; ++component) {
    LoadedRegion faces = loaded_faces(
        place.group, place.region, place.subdomain,
        [&](const geometry::BoundaryTriangle& triangle) {
          return -place.outward[index(triangle.surface)][index(component)];
        },
        factor);
    total_area += faces.total_area;
    LoadCurve amplitude = curve(place.condition, 0);
    if (amplitude.is_zero() || faces.total_area == 0) continue;
    loads.forces.push_back({component, std::move(amplitude), std::move(faces.nodes), std::move(faces.area),
                            faces.total_area, faces.resultant, place.number});
  }
  refuse_empty(place, total_area == 0, "boundary triangle");
  loads.conditions.push_back(area_shares(std::move(region)));
}

/// A fix, displacement or velocity.
void add_motion(const ConditionOnMesh& place, Conditions& loads) {
  const input::Boundary& condition = place.condition;
  const std::vector<std::int32_t> nodes = nodes_in_region(place.region, place.subdomain);
  parallel::check_peers(place.group);
  const auto n = parallel::all_reduce<std::int64_t>(place.group, std::ssize(nodes), MPI_SUM);
  refuse_empty(place, n == 0, "node");
  for (int component = 0; component < 3; ++component) {
    if (!condition.components[index(component)]) continue;
    PrescribedMotion motion;
    motion.component = component;
    motion.is_fixed = condition.kind == BoundaryKind::fix;
    motion.is_velocity = condition.kind == BoundaryKind::velocity;
    if (!motion.is_fixed) motion.curve = curve(condition, component);
    motion.nodes = nodes;
    motion.has_factor = condition.factor.has_value();
    if (motion.has_factor)
      for (const auto node : nodes)
        motion.factor.push_back(condition.factor->at(place.subdomain.nodes[index(node)]));
    motion.condition = place.number;
    loads.motions.push_back(std::move(motion));
  }
  loads.conditions.push_back({nodes, std::vector<double>(nodes.size(), 1 / static_cast<double>(n))});
}

/// The tetrahedron behind each boundary triangle, whose nodes ascend.
std::map<geometry::Triangle, std::int32_t> tetrahedra_behind(const geometry::Subdomain& subdomain) {
  std::map<geometry::Triangle, std::int32_t> behind;
  const auto sorted = [](geometry::Triangle nodes) {
    std::ranges::sort(nodes);
    return nodes;
  };
  for (const auto& triangle : subdomain.boundary) behind[sorted(triangle.nodes)] = 0;
  for (std::size_t t = 0; t < subdomain.tetrahedra.size(); ++t)
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      const auto& nodes = subdomain.tetrahedra[t];
      const auto found = behind.find(
          sorted({nodes[(opposite + 1) % 4], nodes[(opposite + 2) % 4], nodes[(opposite + 3) % 4]}));
      if (found != behind.end()) found->second = static_cast<std::int32_t>(t);
    }
  return behind;
}

void add_dashpots(const ConditionOnMesh& place, Conditions& loads) {
  const auto behind = tetrahedra_behind(place.subdomain);
  std::map<std::int32_t, Symmetric> impedance;
  // One component at a time, by the tributary areas weighted with that component of each face.
  for (std::size_t k = 0; k < 6; ++k) {
    const LoadedRegion part = loaded_faces(
        place.group, place.region, place.subdomain, [&](const geometry::BoundaryTriangle& triangle) {
          geometry::Triangle nodes = triangle.nodes;
          std::ranges::sort(nodes);
          const std::int32_t t = behind.at(nodes);
          const double density = place.material.density[t];
          const double along = density * dilatational_speed(place.material.elasticity[t], density);
          const double across = density * shear_speed(place.material.elasticity[t], density);
          const Vector& normal = place.outward[index(triangle.surface)];
          return (along - across) * symmetric_product(normal, normal)[k] + (k < 3 ? across : 0);
        });
    for (std::size_t n = 0; n < part.nodes.size(); ++n) impedance[part.nodes[n]][k] = part.area[n];
  }
  Absorber absorber;
  for (const auto& [node, value] : impedance) {
    absorber.nodes.push_back(node);
    absorber.impedance.push_back(value);
  }
  parallel::check_peers(place.group);
  refuse_empty(place, !parallel::any_of_all(place.group, !absorber.nodes.empty()), "boundary triangle");
  absorber.condition = place.number;
  loads.absorbers.push_back(std::move(absorber));
  loads.conditions.push_back(area_shares(loaded_region(place.group, place.region, place.subdomain)));
}

}  // namespace

void add_condition(const ConditionOnMesh& place, Conditions& loads) {
  switch (place.condition.kind) {
    case BoundaryKind::force:
    case BoundaryKind::traction:
      return add_vector_load(place, loads);
    case BoundaryKind::pressure:
      return add_pressure(place, loads);
    case BoundaryKind::fix:
    case BoundaryKind::velocity:
    case BoundaryKind::displacement:
      return add_motion(place, loads);
    case BoundaryKind::absorbing:
      return add_dashpots(place, loads);
  }
}

}  // namespace crackle::mechanics
