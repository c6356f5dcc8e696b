// SPDX-License-Identifier: GPL-3.0-or-later
// What CGAL checks and orients.
#include "surface.h"

#include "common/failure.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>
#include <CGAL/Surface_mesh.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace crackle::solid {

namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;
using FaceIndex = Mesh::Face_index;

Vector vector_of(const Point& p) {
  return {p.x(), p.y(), p.z()};
}
Point point_of(const Vector& p) {
  return {p[0], p[1], p[2]};
}

/// Keeps the groups of polygons that are divided into triangles.
struct KeepGroups : pmp::Triangulate_faces::Default_visitor<Mesh> {
  Mesh::Property_map<FaceIndex, int> group;
  int current = -1;
  void before_subface_creations(FaceIndex face) { current = group[face]; }
  void after_subface_created(FaceIndex face) { group[face] = current; }
};

class SurfaceMaker {
public:
  SurfaceMaker(Facets facets, std::string unit) : facets_(std::move(facets)), unit_(std::move(unit)) {}

  Surface make() {
    check_edges();
    make_mesh();
    divide_polygons();
    check_intersections();
    orient();
    Surface surface;
    for (const auto v : mesh_.vertices()) surface.points.push_back(vector_of(mesh_.point(v)));
    for (const FaceIndex face : mesh_.faces()) {
      auto& facet = surface.facets.emplace_back();
      std::size_t i = 0;
      for (const auto v : mesh_.vertices_around_face(mesh_.halfedge(face)))
        facet.at(i++) = static_cast<std::int32_t>(v.idx());
      surface.group.push_back(group_[face]);
    }
    return surface;
  }

private:
  std::string show(const Vector& p) const { return show_place(p, unit_); }

  /// Every edge has two facets.
  void check_edges() {
    std::map<std::pair<std::size_t, std::size_t>, int> n_facets;
    for (const Polygon& polygon : facets_.polygons)
      for (std::size_t i = 0; i < polygon.size(); ++i)
        ++n_facets[std::minmax(polygon[i], polygon[(i + 1) % polygon.size()])];
    for (const auto& [edge, n] : n_facets) {
      const std::string place = fmt::format("the edge from {} to {}", show(facets_.points[edge.first]),
                                            show(facets_.points[edge.second]));
      if (n == 1) fail("is not closed: {} borders on one facet only; close the gap", place);
      if (n > 2) fail("is not the surface of one body: {} facets meet at {}; leave two there", n, place);
    }
  }

  void make_mesh() {
    std::vector<Point> points;
    for (const Vector& p : facets_.points) points.push_back(point_of(p));
    std::vector<Polygon> polygons = facets_.polygons;
    const std::size_t n_before = points.size();
    pmp::orient_polygon_soup(points, polygons);
    // Points at which it had to cut the surface.
    if (points.size() > n_before) {
      std::map<std::pair<std::size_t, std::size_t>, int> n_facets;
      bool is_cut = false;
      for (const Polygon& polygon : polygons)
        for (std::size_t i = 0; i < polygon.size(); ++i)
          ++n_facets[std::minmax(polygon[i], polygon[(i + 1) % polygon.size()])];
      for (const auto& [edge, n] : n_facets) is_cut = is_cut || n == 1;
      const std::string place = show(vector_of(points.back()));
      if (is_cut) fail("has no inside: it cannot be oriented at {}; give the surface of a body", place);
      fail("touches itself in the point {}; move its parts apart, or let them overlap", place);
    }
    pmp::polygon_soup_to_polygon_mesh(points, polygons, mesh_);
    group_ = mesh_.add_property_map<FaceIndex, int>("f:group", -1).first;
    std::size_t i = 0;
    for (const FaceIndex face : mesh_.faces()) group_[face] = facets_.group[i++];
  }

  void divide_polygons() {
    if (CGAL::is_triangle_mesh(mesh_)) return;
    KeepGroups visitor;
    visitor.group = group_;
    if (!pmp::triangulate_faces(mesh_, CGAL::parameters::visitor(visitor)) || !CGAL::is_triangle_mesh(mesh_))
      fail("has facets with more than three corners that cannot be divided into triangles; divide them");
    mesh_.collect_garbage();
  }

  Vector centre(FaceIndex face) const {
    Vector sum{};
    for (const auto v : mesh_.vertices_around_face(mesh_.halfedge(face)))
      sum = sum + vector_of(mesh_.point(v)) / 3;
    return sum;
  }

  void check_intersections() {
    for (const FaceIndex face : mesh_.faces())
      if (pmp::is_degenerate_triangle_face(face, mesh_))
        fail("has a facet without area at {}; remove it", show(centre(face)));
    std::vector<std::pair<FaceIndex, FaceIndex>> pairs;
    pmp::self_intersections(mesh_, std::back_inserter(pairs));
    if (pairs.empty()) return;
    const auto& [one, other] = *std::ranges::min_element(pairs);
    fail("intersects itself: {} of facets meet, such as those at {} and {}; make it the surface of one body",
         pairs.size() == 1 ? "a pair" : fmt::format("{} pairs", pairs.size()), show(centre(one)),
         show(centre(other)));
  }

  /// Makes normals point out of the body.
  void orient() {
    pmp::orient_to_bound_a_volume(mesh_);
    auto component = mesh_.add_property_map<FaceIndex, std::size_t>("f:component", 0).first;
    const std::size_t n = pmp::connected_components(mesh_, component);
    std::vector<double> volume(n, 0);
    std::vector<FaceIndex> first(n);
    const Vector origin = facets_.points.front();
    for (const FaceIndex face : mesh_.faces()) {
      std::array<Vector, 3> p{};
      std::size_t i = 0;
      for (const auto v : mesh_.vertices_around_face(mesh_.halfedge(face)))
        p.at(i++) = vector_of(mesh_.point(v)) - origin;
      if (!first[component[face]].is_valid()) first[component[face]] = face;
      volume[component[face]] += dot(p[0], cross(p[1], p[2])) / 6;
    }
    std::vector<std::size_t> parts;  // the others are cavities
    for (std::size_t i = 0; i < n; ++i)
      if (volume[i] > 0) parts.push_back(i);
    if (parts.size() > 1)
      fail("has {} separate parts, such as at {} and {}; give a body in one piece", parts.size(),
           show(centre(first[parts[0]])), show(centre(first[parts[1]])));
  }

  Facets facets_;
  std::string unit_;
  Mesh mesh_;
  Mesh::Property_map<FaceIndex, int> group_;
};

}  // namespace

Surface make_surface(Facets facets, const std::string& unit) {
  return SurfaceMaker(std::move(facets), unit).make();
}

}  // namespace crackle::solid
