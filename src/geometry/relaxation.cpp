// SPDX-License-Identifier: GPL-3.0-or-later
#include "relaxation.h"

#include "crackle/common/index.h"
#include "crackle/common/vector.h"

#include "tessellation.h"

#include <algorithm>
#include <bit>

namespace crackle::geometry {

namespace {

/// A weight and the weighted vector from the first corner to the circumcentre.
struct Pull {
  double weight;
  Point vector;
};

Pull pull_of_tetrahedron(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Point u = b - a;
  const Point v = c - a;
  const Point w = d - a;
  const Point vw = cross(v, w);
  const Point wu = cross(w, u);
  const Point uv = cross(u, v);
  return {dot(u, vw) / 6, (dot(u, u) * vw + dot(v, v) * wu + dot(w, w) * uv) / 12};
}

Pull pull_of_triangle(const Point& a, const Point& b, const Point& c) {
  const Point u = b - a;
  const Point v = c - a;
  const Point n = cross(u, v);
  const double length = norm(n);
  const Point nu = cross(n, u);
  const Point vn = cross(v, n);
  return {length / 2, (dot(v, v) * nu + dot(u, u) * vn) / (4 * length)};
}

}  // namespace

void relax(const Body& body, MotherPoints& points, const MayMove& may_move) {
  const Tessellation tessellation(body, points.position, 0);
  const TessellationContent content = tessellation.content();
  std::vector<std::uint8_t> stays(points.size(), 0);
  for (const Tetrahedron& crossing : tessellation.bad_cells())
    for (const std::int32_t node : crossing) stays[index(node)] = 1;

  std::vector<Point> sum(points.size(), Point{});
  std::vector<double> weights(points.size(), 0);
  const auto add = [&](std::int32_t node, std::int32_t first, const Pull& pull, double scale) {
    const Point offset = points.position[index(first)] - points.position[index(node)];
    weights[index(node)] += scale * pull.weight;
    sum[index(node)] = sum[index(node)] + scale * (pull.weight * offset + pull.vector);
  };
  const auto position = [&](std::int32_t node) -> const Point& { return points.position[index(node)]; };
  const auto freedom = [&](std::int32_t node) { return std::popcount(points.movable[index(node)]); };

  for (const Tetrahedron& t : content.tetrahedra) {
    const Pull pull = pull_of_tetrahedron(position(t[0]), position(t[1]), position(t[2]), position(t[3]));
    double local = 0;
    for (const std::int32_t node : t) local += points.spacing[index(node)] / 4;
    // A cell pulls with volume times distance, of order spacing^4; this power balances neighbours of
    // different size.
    const double scale = 1 / (local * local * local * local);
    for (const std::int32_t node : t)
      if (freedom(node) == 3) add(node, t[0], pull, scale);
  }
  const auto pull_in_face = [&](const Triangle& t) {
    const Pull pull = pull_of_triangle(position(t[0]), position(t[1]), position(t[2]));
    double local = 0;
    for (const std::int32_t node : t) local += points.spacing[index(node)] / 3;
    const double scale = 1 / (local * local * local);
    for (const std::int32_t node : t)
      if (freedom(node) == 2) add(node, t[0], pull, scale);
  };
  std::ranges::for_each(content.boundary, pull_in_face);
  std::ranges::for_each(content.inner, pull_in_face);

  for (std::size_t i = 0; i < points.size(); ++i) {
    if (stays[i] || !(weights[i] > 0)) continue;
    Point p = points.position[i];
    const Directions directions = body.directions(p, points.movable[i]);
    for (std::size_t k = 0; k < index(directions.n); ++k) {
      p = p + dot(sum[i], directions.vector[k]) / weights[i] * directions.vector[k];
    }
    if (body.contains(p) && body.movable(p) == points.movable[i] && may_move(i, p)) points.position[i] = p;
  }
}

}  // namespace crackle::geometry
