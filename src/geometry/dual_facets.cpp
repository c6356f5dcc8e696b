// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/geometry/dual_facets.h"

#include "crackle/common/index.h"
#include "crackle/common/vector.h"
#include "crackle/geometry/point.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace crackle::geometry {

namespace {

double kronecker(std::size_t i, std::size_t j) {
  return i == j ? 1.0 : 0.0;
}

/// Calls visit with the four indices of each component.
template <class Visit>
void for_components(const Visit& visit) {
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t l = 0; l < 3; ++l) visit(i, j, k, l);
}

/// The distinct node sets of one size (edges or faces), for numbering points shared by several tetrahedra.
template <std::size_t n>
class SharedEntities {
public:
  using Key = std::array<std::int32_t, n>;
  void add(Key key) {
    std::sort(key.begin(), key.end());
    keys_.push_back(key);
  }
  void finish() {
    std::sort(keys_.begin(), keys_.end());
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
  }
  std::int32_t number(Key key) const {
    std::sort(key.begin(), key.end());
    return static_cast<std::int32_t>(std::lower_bound(keys_.begin(), keys_.end(), key) - keys_.begin());
  }
  const std::vector<Key>& keys() const { return keys_; }

private:
  std::vector<Key> keys_;
};

/// The two corners that are not on edge (a, b).
std::array<std::size_t, 2> others(std::size_t a, std::size_t b) {
  std::array<std::size_t, 2> result{};
  for (std::size_t k = 0, n = 0; k < 4; ++k)
    if (k != a && k != b) result[n++] = k;
  return result;
}

}  // namespace

std::array<Point, 6> dual_facet_areas(const Point& a, const Point& b, const Point& c, const Point& d) {
  // V grad N of each node is a third of the inward vector area of the face opposite to it.
  const Point u = b - a;
  const Point v = c - a;
  const Point w = d - a;
  std::array<Point, 4> gradient{Point{}, cross(v, w) / 6, cross(w, u) / 6, cross(u, v) / 6};
  for (std::size_t k = 1; k < 4; ++k) gradient[0] = gradient[0] - gradient[k];
  std::array<Point, 6> areas{};
  for (std::size_t facet = 0; facet < 6; ++facet)
    areas[facet] = (gradient[dual_facet_nodes[facet][1]] - gradient[dual_facet_nodes[facet][0]]) / 4;
  return areas;
}

void add_share(OrientationMoments& moments, const OrientationMoments& other, double share) {
  moments.area += share * other.area;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) moments.second[i][j] += share * other.second[i][j];
  for_components([&](std::size_t i, std::size_t j, std::size_t k, std::size_t l) {
    moments.fourth[i][j][k][l] += share * other.fourth[i][j][k][l];
  });
}

OrientationMoments orientation_moments(const Realization& realization,
                                       const std::function<bool(const Point& centroid)>& region) {
  OrientationMoments moments;
  for (const Tetrahedron& t : realization.tetrahedra) {
    if (!region(centroid(realization.nodes, t))) continue;
    const auto areas = dual_facet_areas(realization.nodes[index(t[0])], realization.nodes[index(t[1])],
                                        realization.nodes[index(t[2])], realization.nodes[index(t[3])]);
    for (const Point& s : areas) {
      const double area = norm(s);
      if (!(area > 0)) continue;
      moments.area += area;
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) moments.second[i][j] += s[i] * s[j] / area;
      for_components([&](std::size_t i, std::size_t j, std::size_t k, std::size_t l) {
        moments.fourth[i][j][k][l] += s[i] * s[j] / area * (s[k] / area) * (s[l] / area);
      });
    }
  }
  if (!(moments.area > 0)) return moments;
  for (auto& row : moments.second)
    for (double& value : row) value /= moments.area;
  for_components([&](std::size_t i, std::size_t j, std::size_t k, std::size_t l) {
    moments.fourth[i][j][k][l] /= moments.area;
  });
  return moments;
}

double second_order_bias(const OrientationMoments& moments) {
  double distance = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const double deviation = moments.second[i][j] - kronecker(i, j) / 3;
      distance += deviation * deviation;
    }
  return std::sqrt(distance / (1.0 / 3));
}

double fourth_order_bias(const OrientationMoments& moments) {
  double distance = 0;
  double size = 0;
  for_components([&](std::size_t i, std::size_t j, std::size_t k, std::size_t l) {
    const double isotropic = (kronecker(i, j) * kronecker(k, l) + kronecker(i, k) * kronecker(j, l) +
                              kronecker(i, l) * kronecker(j, k)) /
                             15;
    const double deviation = moments.fourth[i][j][k][l] - isotropic;
    distance += deviation * deviation;
    size += isotropic * isotropic;
  });
  return std::sqrt(distance / size);
}

DualSurface dual_surface(const Realization& realization) {
  SharedEntities<2> edges;
  SharedEntities<3> faces;
  for (const Tetrahedron& t : realization.tetrahedra)
    for (const auto& [a, b] : dual_facet_nodes) {
      edges.add({t[a], t[b]});
      for (const std::size_t c : others(a, b)) faces.add({t[a], t[b], t[c]});
    }
  edges.finish();
  faces.finish();

  DualSurface surface;
  const auto first_face = static_cast<std::int32_t>(edges.keys().size());
  const auto first_centroid = first_face + static_cast<std::int32_t>(faces.keys().size());
  for (const auto& edge : edges.keys()) surface.points.push_back(centroid(realization.nodes, edge));
  for (const auto& face : faces.keys()) surface.points.push_back(centroid(realization.nodes, face));
  for (const auto& t : realization.tetrahedra) surface.points.push_back(centroid(realization.nodes, t));
  for (std::size_t i = 0; i < realization.tetrahedra.size(); ++i) {
    const Tetrahedron& t = realization.tetrahedra[i];
    for (const auto& [a, b] : dual_facet_nodes) {
      const auto [c, d] = others(a, b);
      surface.quadrilaterals.push_back(
          {edges.number({t[a], t[b]}), first_face + faces.number({t[a], t[b], t[c]}),
           first_centroid + static_cast<std::int32_t>(i), first_face + faces.number({t[a], t[b], t[d]})});
      surface.tetrahedron.push_back(static_cast<std::int32_t>(i));
    }
  }
  return surface;
}

}  // namespace crackle::geometry
