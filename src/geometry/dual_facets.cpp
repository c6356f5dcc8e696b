// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/dual_facets.h"

#include "common/index.h"
#include "common/vector.h"
#include "geometry/point.h"

#include <algorithm>

namespace crackle::geometry {

namespace {

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
