// SPDX-License-Identifier: GPL-3.0-or-later
#include "plain_delaunay.h"

#include "common/stopwatch.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <unordered_map>

namespace crackle::geometry {

PlainDelaunay plain_delaunay(std::span<const Point> points) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Delaunay = CGAL::Delaunay_triangulation_3<Kernel>;
  std::vector<Kernel::Point_3> positions;
  positions.reserve(points.size());
  for (const Point& p : points) positions.emplace_back(p[0], p[1], p[2]);

  PlainDelaunay result;
  const ThreadClock clock;
  const Delaunay delaunay(positions.begin(), positions.end());
  result.seconds = clock.seconds();

  std::unordered_map<const Delaunay::Vertex*, std::int32_t> number;
  number.reserve(points.size());
  for (const auto vertex : delaunay.finite_vertex_handles()) {
    number.emplace(&*vertex, static_cast<std::int32_t>(result.nodes.size()));
    result.nodes.push_back({vertex->point().x(), vertex->point().y(), vertex->point().z()});
  }
  result.tetrahedra.reserve(delaunay.number_of_finite_cells());
  for (const auto cell : delaunay.finite_cell_handles()) {
    Tetrahedron nodes{};
    for (std::size_t i = 0; i < 4; ++i) nodes[i] = number.at(&*cell->vertex(static_cast<int>(i)));
    result.tetrahedra.push_back(nodes);
  }
  return result;
}

}  // namespace crackle::geometry
