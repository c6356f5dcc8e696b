// SPDX-License-Identifier: GPL-3.0-or-later
#include "tessellation.h"

#include "common/index.h"
#include "geometry/quality.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_data_structure_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <array>
#include <compare>
#include <iterator>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace crackle::geometry {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::int32_t, Kernel>;

struct CellInfo {
  double quality = 1;       ///< its third power; valid, as the place is, for finite cells
  std::uint32_t trial = 0;  ///< the last trial that would have replaced the cell
  Containment place = Containment::inside;
};
using CellBase = CGAL::Triangulation_cell_base_with_info_3<CellInfo, Kernel>;
using DataStructure = CGAL::Triangulation_data_structure_3<VertexBase, CellBase>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, DataStructure>;
using CellHandle = Delaunay::Cell_handle;
using VertexHandle = Delaunay::Vertex_handle;
using Facet = Delaunay::Facet;

/// Corners of the face opposite to corner i of a positively oriented cell, with the normal outwards.
constexpr std::array<std::array<int, 3>, 4> outward_face{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

Kernel::Point_3 kernel_point(const Point& p) {
  return {p[0], p[1], p[2]};
}

void sort4(Tetrahedron& t) {
  const auto order = [&](std::size_t i, std::size_t j) {
    if (t[j] < t[i]) std::swap(t[i], t[j]);
  };
  order(0, 1);
  order(2, 3);
  order(0, 2);
  order(1, 3);
  order(1, 2);
}

/// A cell's share in the stiffness and the mass of one of its nodes, or a sum of such shares.
struct NodeShare {
  double stiffness = 0;
  double mass = 0;

  auto operator<=>(const NodeShare&) const = default;
  NodeShare operator+(const NodeShare& other) const {
    return {stiffness + other.stiffness, mass + other.mass};
  }
  double ratio() const { return stiffness / mass; }
};

/// A cell's shape; `quality` is the third power of the mean ratio.
struct Rating {
  bool good;
  double quality;
};

}  // namespace

struct Tessellation::Data {
  const Body& body;
  std::vector<Point> points;
  double min_quality_cubed = 0;
  Delaunay delaunay;
  std::vector<VertexHandle> vertices;
  std::vector<std::uint8_t> on_surface;  // points stay on their surfaces

  std::int32_t lifted = -1;
  std::vector<std::pair<CellHandle, Rating>> filling;  // cells created by lifting
  mutable std::uint32_t trial = 0;
  mutable std::vector<Facet> zone_boundary;
  mutable std::vector<CellHandle> zone;

  Data(const Body& the_body, std::span<const Point> the_points)
      : body(the_body),
        points(the_points.begin(), the_points.end()),
        vertices(the_points.size()),
        on_surface(the_points.size(), 0) {}

  Tetrahedron nodes(CellHandle cell) const {
    return {cell->vertex(0)->info(), cell->vertex(1)->info(), cell->vertex(2)->info(),
            cell->vertex(3)->info()};
  }

  Containment place_of(const Tetrahedron& cell) const {
    return body.classify(
        {points[index(cell[0])], points[index(cell[1])], points[index(cell[2])], points[index(cell[3])]});
  }

  /// @param cell nodes in ascending order, for bitwise equal ratings of equal cells
  Rating rate(const Tetrahedron& cell) const { return rate(cell, place_of(cell)); }

  Rating rate(const Tetrahedron& cell, Containment place) const {
    if (place == Containment::outside) return {true, 1};
    if (place == Containment::straddling) return {false, 0};
    const double quality = mean_ratio_cubed(points[index(cell[0])], points[index(cell[1])],
                                            points[index(cell[2])], points[index(cell[3])]);
    return {quality >= min_quality_cubed, quality};
  }

  /// The same of a finite cell of the tessellation.
  bool is_good(CellHandle cell) const {
    const CellInfo& info = cell->info();
    return info.place != Containment::straddling &&
           (info.place == Containment::outside || info.quality >= min_quality_cubed);
  }

  /// True if a face parts two materials; only from one of the two cells that have it.
  bool parts_materials(CellHandle cell, CellHandle neighbour, const Triangle& face) const {
    const auto opposite = [&](CellHandle one) {
      std::int32_t sum = 0;
      for (const std::int32_t node : nodes(one)) sum += node;
      for (const std::int32_t node : face) sum -= node;
      return sum;
    };
    const auto material = [&](CellHandle one) { return body.material_at(centroid(points, nodes(one))); };
    return cell->info().place == Containment::inside && neighbour->info().place == Containment::inside &&
           opposite(cell) < opposite(neighbour) && material(cell) != material(neighbour);
  }

  Tetrahedron sorted_nodes(CellHandle cell) const {
    Tetrahedron result = nodes(cell);
    sort4(result);
    return result;
  }

  /// The shares of a cell in the stiffness and the mass of its node `corner`.
  /// @param face the other three; in ascending order, for bitwise equal shares of equal cells
  NodeShare share(std::int32_t corner, Triangle face) const {
    std::ranges::sort(face);
    const Point& p = points[index(face[0])];
    const Point normal = cross(points[index(face[1])] - p, points[index(face[2])] - p) / 2;
    const double volume = std::abs(dot(normal, points[index(corner)] - p)) / 3;
    return {dot(normal, normal) / (9 * volume), volume / 4};
  }

  NodeShare share(CellHandle cell, std::size_t corner) const {
    const Tetrahedron t = nodes(cell);
    return share(t[corner], {t[(corner + 1) % 4], t[(corner + 2) % 4], t[(corner + 3) % 4]});
  }

  /// Records a new cell's place and quality; appends its nodes to `bad` if it is bad.
  Rating enter(CellHandle cell, std::vector<Tetrahedron>* bad) const {
    cell->info() = CellInfo{};
    if (delaunay.is_infinite(cell)) return {true, 1};
    const Tetrahedron sorted = sorted_nodes(cell);
    cell->info().place = place_of(sorted);
    const Rating rating = rate(sorted, cell->info().place);
    cell->info().quality = rating.quality;
    if (bad != nullptr && !rating.good) bad->push_back(sorted);
    return rating;
  }
};

Tessellation::Tessellation(const Body& body, std::span<const Point> points, double min_quality)
    : data_(std::make_unique<Data>(body, points)) {
  set_min_quality(min_quality);
  std::vector<std::pair<Kernel::Point_3, std::int32_t>> numbered(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    numbered[i] = {kernel_point(points[i]), static_cast<std::int32_t>(i)};
  data_->delaunay.insert(numbered.begin(), numbered.end());
  if (data_->delaunay.number_of_vertices() != points.size() || data_->delaunay.dimension() != 3)
    throw std::runtime_error("mother points: two points coincide, or all lie in one plane");
  for (const VertexHandle vertex : data_->delaunay.finite_vertex_handles())
    data_->vertices[index(vertex->info())] = vertex;
  for (std::size_t i = 0; i < points.size(); ++i) data_->on_surface[i] = body.place_of(points[i]) >= 0;
  for (const CellHandle cell : data_->delaunay.finite_cell_handles()) data_->enter(cell, nullptr);
}

Tessellation::~Tessellation() = default;

void Tessellation::set_min_quality(double min_quality) {
  data_->min_quality_cubed = min_quality * min_quality * min_quality;
}

std::span<const Point> Tessellation::points() const {
  return data_->points;
}

std::vector<Tetrahedron> Tessellation::bad_cells() const {
  std::vector<Tetrahedron> bad;
  for (const CellHandle cell : data_->delaunay.finite_cell_handles())
    if (!data_->is_good(cell)) bad.push_back(data_->sorted_nodes(cell));
  std::sort(bad.begin(), bad.end());
  return bad;
}

bool Tessellation::has_bad_cell(const Tetrahedron& nodes) const {
  CellHandle cell;
  const auto& vertices = data_->vertices;
  return !data_->rate(nodes).good &&
         data_->delaunay.is_cell(vertices[index(nodes[0])], vertices[index(nodes[1])],
                                 vertices[index(nodes[2])], vertices[index(nodes[3])], cell);
}

std::vector<std::int32_t> Tessellation::neighbours(std::int32_t node) const {
  std::vector<VertexHandle> adjacent;
  data_->delaunay.finite_adjacent_vertices(data_->vertices[index(node)], std::back_inserter(adjacent));
  std::vector<std::int32_t> result;
  result.reserve(adjacent.size());
  for (const VertexHandle vertex : adjacent) result.push_back(vertex->info());
  std::sort(result.begin(), result.end());
  return result;
}

double Tessellation::stiffness_over_mass(std::int32_t node) const {
  const Data& data = *data_;
  const VertexHandle vertex = data.vertices[index(node)];
  std::vector<CellHandle> cells;
  cells.reserve(64);
  data.delaunay.finite_incident_cells(vertex, std::back_inserter(cells));
  std::vector<NodeShare> shares;
  shares.reserve(cells.size());
  for (const CellHandle cell : cells)
    if (cell->info().place != Containment::outside)
      shares.push_back(data.share(cell, index(cell->index(vertex))));
  std::ranges::sort(shares);  // sums that do not depend on the order of the cells
  return std::accumulate(shares.begin(), shares.end(), NodeShare{}).ratio();
}

std::vector<double> Tessellation::stiffness_over_mass() const {
  const Data& data = *data_;
  std::vector<NodeShare> shares(data.points.size());
  for (const CellHandle cell : data.delaunay.finite_cell_handles()) {
    if (cell->info().place == Containment::outside) continue;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t node = index(cell->vertex(static_cast<int>(k))->info());
      shares[node] = shares[node] + data.share(cell, k);
    }
  }
  std::vector<double> result(shares.size());
  std::ranges::transform(shares, result.begin(), &NodeShare::ratio);
  return result;
}

void Tessellation::lift(std::int32_t node) {
  Data& data = *data_;
  std::vector<CellHandle> made;
  data.delaunay.remove_and_give_new_cells(data.vertices[index(node)], std::back_inserter(made));
  data.vertices[index(node)] = VertexHandle();
  data.lifted = node;
  data.filling.clear();
  for (const CellHandle cell : made) data.filling.emplace_back(cell, data.enter(cell, nullptr));
}

Tessellation::Trial Tessellation::try_at(const Point& p, const Trial& enough) const {
  const Data& data = *data_;
  const Trial hopeless;
  Delaunay::Locate_type type{};
  int i = 0;
  int j = 0;
  const Kernel::Point_3 position = kernel_point(p);
  const CellHandle cell = data.delaunay.locate(position, type, i, j, data.filling.front().first);
  // Due to rounding, a point on an oblique wall can lie outside the convex hull of the others.
  if (type == Delaunay::VERTEX || type == Delaunay::OUTSIDE_AFFINE_HULL) return hopeless;

  data.zone.clear();
  data.zone_boundary.clear();
  data.delaunay.find_conflicts(position, cell, std::back_inserter(data.zone_boundary),
                               std::back_inserter(data.zone));
  ++data.trial;
  for (const CellHandle conflict : data.zone) conflict->info().trial = data.trial;

  Trial result{0, 1};
  const auto count = [&](const Rating& rating) {
    result.n_bad += !rating.good;
    result.worst = std::min(result.worst, rating.quality);
  };
  for (const auto& [remaining, rating] : data.filling)
    if (remaining->info().trial != data.trial) count(rating);

  data_->points[index(data.lifted)] = p;
  for (const auto& [inside, opposite] : data.zone_boundary) {
    Tetrahedron nodes{};
    bool infinite = false;
    for (std::size_t k = 0; k < 4; ++k) {
      const VertexHandle vertex = inside->vertex(static_cast<int>(k));
      if (static_cast<int>(k) == opposite) {
        nodes[k] = data.lifted;
      } else if (data.delaunay.is_infinite(vertex)) {
        infinite = true;
      } else {
        nodes[k] = vertex->info();
      }
    }
    if (infinite) continue;
    sort4(nodes);
    count(data.rate(nodes));
    if (!result.better_than(enough)) return hopeless;
  }
  return result;
}

double Tessellation::tried_stiffness_over_mass() const {
  const Data& data = *data_;
  NodeShare sum;
  for (const auto& [inside, opposite] : data.zone_boundary) {
    Tetrahedron nodes{data.lifted};
    bool is_infinite = false;
    for (int k = 1; k < 4; ++k) {
      const VertexHandle vertex = inside->vertex((opposite + k) % 4);
      is_infinite = is_infinite || data.delaunay.is_infinite(vertex);
      nodes[index(k)] = vertex->info();
    }
    if (is_infinite) continue;
    const NodeShare share = data.share(nodes[0], {nodes[1], nodes[2], nodes[3]});
    // Only cells all of whose nodes are on the surface can be outside the body.
    if (std::ranges::all_of(nodes, [&](std::int32_t node) { return data.on_surface[index(node)] != 0; })) {
      sort4(nodes);
      if (data.place_of(nodes) == Containment::outside) continue;
    }
    sum = sum + share;
  }
  return sum.ratio();
}

void Tessellation::put(const Point& p, std::vector<Tetrahedron>& bad) {
  Data& data = *data_;
  const Trial worst;
  // Marks the remaining cells of the filling; the others are about to be replaced.
  try_at(p, worst);
  std::vector<CellHandle> changed;
  for (const auto& [cell, rating] : data.filling)
    if (cell->info().trial != data.trial && !rating.good) bad.push_back(data.sorted_nodes(cell));

  data.points[index(data.lifted)] = p;
  const Facet& facet = data.zone_boundary.front();
  const VertexHandle vertex = data.delaunay.insert_in_hole(kernel_point(p), data.zone.begin(),
                                                           data.zone.end(), facet.first, facet.second);
  vertex->info() = data.lifted;
  data.vertices[index(data.lifted)] = vertex;
  data.delaunay.incident_cells(vertex, std::back_inserter(changed));
  for (const CellHandle cell : changed) data.enter(cell, &bad);
  data.lifted = -1;
  data.filling.clear();
}

TessellationContent Tessellation::content() const {
  const Data& data = *data_;
  TessellationContent content;
  content.tetrahedra.reserve(data.points.size() * 6);
  const bool has_inner = !data.body.inner_faces().empty();
  for (const CellHandle cell : data.delaunay.finite_cell_handles()) {
    if (cell->info().place == Containment::outside) continue;
    const Tetrahedron nodes = data.nodes(cell);
    content.tetrahedra.push_back(nodes);
    for (std::size_t i = 0; i < 4; ++i) {
      Triangle face{};
      bool on_surface = true;
      for (std::size_t k = 0; k < 3; ++k) {
        face[k] = nodes[index(outward_face[i][k])];
        on_surface = on_surface && data.on_surface[index(face[k])];
      }
      if (!on_surface) continue;
      const CellHandle neighbour = cell->neighbor(static_cast<int>(i));
      if (data.delaunay.is_infinite(neighbour) || neighbour->info().place == Containment::outside)
        content.boundary.push_back(face);
      else if (has_inner && data.parts_materials(cell, neighbour, face))
        content.inner.push_back(face);
    }
  }
  return content;
}

}  // namespace crackle::geometry
