// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/mesh_statistics.h"

#include "common/index.h"
#include "common/vector.h"
#include "geometry/quality.h"

#include <algorithm>
#include <numbers>
#include <utility>

namespace crackle::geometry {

Quantiles quantiles(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  return {values.front(), values[values.size() / 100], values[values.size() / 2], values.back()};
}

MeshStatistics mesh_statistics(const Realization& realization) {
  MeshStatistics statistics;
  statistics.smallest_angle = std::numbers::pi;
  std::vector<double> quality;
  std::vector<std::pair<std::int32_t, std::int32_t>> edges;
  quality.reserve(realization.tetrahedra.size());
  edges.reserve(6 * realization.tetrahedra.size());
  for (const Tetrahedron& t : realization.tetrahedra) {
    std::array<Point, 4> corner{};
    for (std::size_t i = 0; i < 4; ++i) {
      corner[i] = realization.nodes[index(t[i])];
      for (std::size_t j = 0; j < i; ++j) edges.push_back(std::minmax(t[i], t[j]));
    }
    quality.push_back(mean_ratio(corner[0], corner[1], corner[2], corner[3]));
    for (const double angle : dihedral_angles(corner[0], corner[1], corner[2], corner[3])) {
      statistics.smallest_angle = std::min(statistics.smallest_angle, angle);
      statistics.largest_angle = std::max(statistics.largest_angle, angle);
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  std::vector<double> length;
  length.reserve(edges.size());
  for (const auto& [a, b] : edges)
    length.push_back(norm(realization.nodes[index(a)] - realization.nodes[index(b)]));
  statistics.n_edges = static_cast<std::int64_t>(edges.size());
  statistics.edge_length = quantiles(std::move(length));
  statistics.quality = quantiles(std::move(quality));
  return statistics;
}

std::vector<MaterialContents> material_contents(const Realization& realization) {
  std::vector<MaterialContents> contents;
  for (std::size_t i = 0; i < realization.material.size(); ++i) {
    const std::size_t material = realization.material[i];
    if (material >= contents.size()) contents.resize(material + 1);
    const Tetrahedron& t = realization.tetrahedra[i];
    const auto node = [&](std::size_t k) -> const Point& { return realization.nodes[index(t[k])]; };
    ++contents[material].tetrahedra;
    contents[material].volume += signed_volume(node(0), node(1), node(2), node(3));
  }
  return contents;
}

}  // namespace crackle::geometry
