// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/index.h"
#include "common/vector.h"
#include "geometry/quality.h"
#include "geometry/realization.h"
#include "parallel/exact_sum.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace crackle::geometry {

namespace {

constexpr double relative_tolerance = 1e-12;

template <class... Arguments>
[[noreturn]] void violation(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  throw std::runtime_error("realization: " + fmt::format(format, std::forward<Arguments>(arguments)...));
}

/// Small materials have the rounding of the body's coordinates.
constexpr double rounding = 1e-15;

bool same(double value, double exact) {
  return std::abs(value - exact) <= relative_tolerance * exact;
}

/// @return quality of the worst tetrahedron, as its third power
double check_tetrahedra(const Realization& realization, const Body& body, double min_quality) {
  const auto& nodes = realization.nodes;
  const auto n_nodes = static_cast<std::int32_t>(nodes.size());
  std::vector<std::uint8_t> used(nodes.size(), 0);
  parallel::ExactSum volume;
  double worst = 1;
  for (std::size_t i = 0; i < realization.tetrahedra.size(); ++i) {
    const Tetrahedron& t = realization.tetrahedra[i];
    for (const std::int32_t node : t) {
      if (node < 0 || node >= n_nodes) violation("tetrahedron {} has the node {} of {}", i, node, n_nodes);
      used[index(node)] = 1;
    }
    const std::array<Point, 4> corner{nodes[index(t[0])], nodes[index(t[1])], nodes[index(t[2])],
                                      nodes[index(t[3])]};
    const double own = signed_volume(corner[0], corner[1], corner[2], corner[3]);
    if (!(own > 0)) violation("tetrahedron {} has the volume {:g} m^3", i, own);
    volume.add(own);
    // In ascending order of nodes, as in the tessellation, for bitwise equal results.
    Tetrahedron sorted = t;
    std::sort(sorted.begin(), sorted.end());
    const double quality = mean_ratio_cubed(nodes[index(sorted[0])], nodes[index(sorted[1])],
                                            nodes[index(sorted[2])], nodes[index(sorted[3])]);
    if (quality < min_quality * min_quality * min_quality)
      violation("tetrahedron {} has the quality {:g}, below min_quality = {:g}", i, std::cbrt(quality),
                min_quality);
    worst = std::min(worst, quality);
    if (body.classify(corner) != Containment::inside)
      violation("tetrahedron {} extends beyond the body or its material", i);
  }
  const auto unused = std::find(used.begin(), used.end(), 0);
  if (unused != used.end()) violation("node {} belongs to no tetrahedron", unused - used.begin());
  if (!same(volume.value(), body.volume()))
    violation("the tetrahedra have the volume {:.17g} m^3, the body {:.17g} m^3", volume.value(),
              body.volume());
  return worst;
}

void check_materials(const Realization& realization, const Body& body) {
  const std::vector<double>& expected = body.material_volumes();
  const std::size_t n_expected = expected.empty() ? 0 : realization.tetrahedra.size();
  if (realization.material.size() != n_expected)
    violation("{} materials are listed for {} tetrahedra", realization.material.size(), n_expected);
  std::vector<parallel::ExactSum> volume(expected.size());
  for (std::size_t i = 0; i < realization.material.size(); ++i) {
    const std::size_t material = realization.material[i];
    if (material >= expected.size()) violation("tetrahedron {} has the material {}", i, material);
    const Tetrahedron& t = realization.tetrahedra[i];
    const auto node = [&](std::size_t k) -> const Point& { return realization.nodes[index(t[k])]; };
    volume[material].add(signed_volume(node(0), node(1), node(2), node(3)));
  }
  for (std::size_t material = 0; material < expected.size(); ++material) {
    const double own = volume[material].value();
    if (std::abs(own - expected[material]) >
        std::max(relative_tolerance * expected[material], rounding * body.volume()))
      violation("material {} has the volume {:.17g} m^3 instead of {:.17g} m^3", material, own,
                expected[material]);
  }
}

/// Corners of the face opposite to each corner, with the normal outwards.
constexpr std::array<std::array<std::size_t, 3>, 4> outward_face{
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// Faces of all tetrahedra without a counterpart of opposite orientation: smallest node first, normal
/// outwards, ascending.
std::vector<Triangle> unmatched_faces(const Realization& realization) {
  // A face with nodes a < b < c goes into bucket a, with the key b, c, orientation.
  struct Face {
    std::int32_t a;
    std::uint64_t key;
  };
  const auto face_of = [](const Tetrahedron& t, std::size_t i) {
    const auto& corners = outward_face[i];
    Triangle f{t[corners[0]], t[corners[1]], t[corners[2]]};
    std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
    const bool flipped = f[1] > f[2];
    if (flipped) std::swap(f[1], f[2]);
    return Face{f[0], (static_cast<std::uint64_t>(f[1]) << 33) | (static_cast<std::uint64_t>(f[2]) << 1) |
                          static_cast<std::uint64_t>(flipped)};
  };
  std::vector<std::size_t> begin(realization.nodes.size() + 1, 0);
  for (const Tetrahedron& t : realization.tetrahedra)
    for (std::size_t i = 0; i < 4; ++i) ++begin[index(face_of(t, i).a) + 1];
  for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  std::vector<std::uint64_t> keys(4 * realization.tetrahedra.size());
  for (const Tetrahedron& t : realization.tetrahedra)
    for (std::size_t i = 0; i < 4; ++i) {
      const Face face = face_of(t, i);
      keys[next[index(face.a)]++] = face.key;
    }

  std::vector<Triangle> unmatched;
  for (std::size_t a = 0; a + 1 < begin.size(); ++a) {
    const auto first = keys.begin() + static_cast<std::ptrdiff_t>(begin[a]);
    const auto last = keys.begin() + static_cast<std::ptrdiff_t>(begin[a + 1]);
    std::sort(first, last);
    for (auto key = first; key != last; ++key) {
      const auto after = key + 1;
      const auto b = static_cast<std::int32_t>(*key >> 33);
      const auto c = static_cast<std::int32_t>((*key >> 1) & 0x7FFFFFFFu);
      if (after != last && (*key ^ *after) == 1u) {
        ++key;
        continue;
      }
      if (after != last && *key == *after)
        violation("two tetrahedra overlap at the face of the nodes {}, {}, {}", a, b, c);
      const bool flipped = *key & 1u;
      unmatched.push_back({static_cast<std::int32_t>(a), flipped ? c : b, flipped ? b : c});
    }
  }
  std::sort(unmatched.begin(), unmatched.end());
  return unmatched;
}

void check_boundary(const Realization& realization, const Body& body) {
  const std::vector<Triangle> expected = unmatched_faces(realization);
  const auto& boundary = realization.boundary;
  if (expected.size() != boundary.size())
    violation("{} boundary triangles are listed, but {} faces have only one tetrahedron", boundary.size(),
              expected.size());
  std::vector<parallel::ExactSum> area(body.faces().size());
  for (std::size_t i = 0; i < boundary.size(); ++i) {
    const auto& [t, id] = boundary[i];
    if (t != expected[i])
      violation("boundary triangle {} is not the face {}, {}, {} of a tetrahedron", i, expected[i][0],
                expected[i][1], expected[i][2]);
    if (id < 0 || index(id) >= body.faces().size())
      violation("boundary triangle {} has the surface {}", i, id);
    for (const std::int32_t node : t)
      if (!body.in_face(id, realization.nodes[index(node)]))
        violation("node {} of boundary triangle {} does not lie exactly on surface {}", node, i, id);
    const Point& a = realization.nodes[index(t[0])];
    const Point normal = cross(realization.nodes[index(t[1])] - a, realization.nodes[index(t[2])] - a);
    const double projected = dot(normal, body.faces()[index(id)].outward) / 2;
    if (!(projected > 0)) violation("boundary triangle {} is not oriented outwards", i);
    area[index(id)].add(projected);
  }
  for (std::size_t id = 0; id < area.size(); ++id)
    if (!same(area[id].value(), body.faces()[id].area))
      violation("surface {} is covered by {:.17g} m^2 of boundary triangles; its area is {:.17g} m^2", id,
                area[id].value(), body.faces()[id].area);
}

}  // namespace

double verify(const Realization& realization, const Body& body, double min_quality) {
  const double worst = check_tetrahedra(realization, body, min_quality);
  check_boundary(realization, body);
  check_materials(realization, body);
  return std::cbrt(worst);
}

}  // namespace crackle::geometry
