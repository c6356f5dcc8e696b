// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/mesh_regions.h"

#include "common/index.h"
#include "common/real.h"
#include "geometry/symmetry.h"

#include <algorithm>

namespace crackle::geometry {

Box box_of(const input::MeshRegion& region, const Box& bounds) {
  Box box{};
  for (std::size_t i = 0; i < 3; ++i) {
    box.lower[i] = std::max(region.box[i].first, bounds.lower[i]);
    box.upper[i] = std::min(region.box[i].second, bounds.upper[i]);
  }
  return box;
}

std::vector<std::int32_t> region_numbers(std::span<const Point> points, const Body& body,
                                         const input::Mesh& mesh) {
  std::vector<Box> boxes;
  for (const input::MeshRegion& region : mesh.regions) boxes.push_back(box_of(region, body.bounds()));
  std::vector<std::int32_t> numbers;
  numbers.reserve(points.size());
  for (const Point& p : points) {
    const auto found = std::ranges::find_if(boxes, [&](const Box& box) { return box.contains(p); });
    numbers.push_back(found == boxes.end() ? -1 : static_cast<std::int32_t>(found - boxes.begin()));
  }
  return numbers;
}

std::vector<RegionContent> region_contents(const Realization& realization, const Body& body,
                                           const input::Mesh& mesh) {
  std::vector<Point> centroids;
  centroids.reserve(realization.tetrahedra.size());
  for (const Tetrahedron& t : realization.tetrahedra) centroids.push_back(centroid(realization.nodes, t));
  std::vector<RegionContent> contents(mesh.regions.size() + 1);
  const auto of = [&](std::int32_t number) -> RegionContent& {
    return number < 0 ? contents.back() : contents[index(number)];
  };
  for (const auto number : region_numbers(realization.nodes, body, mesh)) ++of(number).nodes;
  for (const auto number : region_numbers(centroids, body, mesh)) ++of(number).tetrahedra;
  return contents;
}

std::vector<std::int32_t> refined_interior(const Realization& realization, const Body& body,
                                           const input::Mesh& mesh) {
  constexpr double fine_factor = 2, depth = 2;
  const SpacingField wanted(body, mesh);
  std::vector<std::int32_t> refined;
  refined.reserve(realization.tetrahedra.size());
  for (const Tetrahedron& t : realization.tetrahedra) {
    const Point p = centroid(realization.nodes, t);
    const double spacing = wanted(p);
    const bool is_fine = spacing <= fine_factor * mesh.notch_spacing;
    refined.push_back(is_fine && body.distance_to_surface(p) >= depth * spacing ? 1 : 0);
  }
  return refined;
}

std::vector<Point> relative_displacements(const Body& body, const MotherPoints& base,
                                          const Realization& realization, const input::Mesh& mesh) {
  const Symmetry symmetry = symmetry_of(body, realization.report.symmetry);
  std::vector<Point> relative(base.size());
  for (std::size_t k = 0; k < base.size(); ++k) {
    const Point node = symmetry.preimage(realization.nodes[k]);
    for (std::size_t i = 0; i < 3; ++i)
      relative[k][i] = ((base.movable[k] >> i) & 1u) == 0
                           ? not_a_number
                           : (node[i] - base.position[k][i]) / (mesh.perturbation * base.spacing[k]);
  }
  return relative;
}

}  // namespace crackle::geometry
