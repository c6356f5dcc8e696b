// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "common/random.h"
#include "cracks/crack_surface.h"

#include "support/structured_mesh.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace crackle::test {

/// Selects the tetrahedra of a realization that break.
struct Cutting {
  /// The part of the body that contains a point; the crack runs between parts.
  std::function<int(const geometry::Point&)> label;
  /// Decides whether a tetrahedron between parts breaks, from its centroid and the labels of its nodes.
  std::function<bool(const geometry::Point&, const std::array<int, 4>&)> is_cracked;
  /// Share of the tetrahedra touching the crack that break with it.
  double touching = 0;
  /// Decides whether a tetrahedron away from the crack breaks.
  std::function<bool(const geometry::Point&, RandomStream&)> is_stray = {};
  /// Share of the broken tetrahedra that open by any of the seven cuts instead of the one along the crack.
  double random_cuts = 1;
  /// When a tetrahedron breaks [s], from its centroid; all at 0 without it.
  std::function<double(const geometry::Point&)> time = {};
};

/// The crack surface as computed by the program.
inline cracks::CrackSurface cut(const geometry::Body& body, const geometry::Realization& realization,
                                const Cutting& cutting, RandomStream random) {
  const auto& tetrahedra = realization.tetrahedra;
  std::vector<int> label;
  for (const geometry::Point& p : realization.nodes) label.push_back(cutting.label(p));
  std::vector<char> at_crack(realization.nodes.size(), 0);
  std::vector<int> cut_of(tetrahedra.size(), -1);
  std::vector<geometry::Point> centroid(tetrahedra.size());
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
    std::array<int, 4> labels{};
    for (std::size_t a = 0; a < 4; ++a) {
      const auto node = static_cast<std::size_t>(tetrahedra[t][a]);
      labels[a] = label[node];
      for (std::size_t i = 0; i < 3; ++i) centroid[t][i] += realization.nodes[node][i] / 4;
    }
    const int found = StructuredMesh::cut_between(labels);
    if (found < 0 || !cutting.is_cracked(centroid[t], labels)) continue;
    cut_of[t] = found;
    for (const auto node : tetrahedra[t]) at_crack[index(node)] = 1;
  }
  std::vector<fracture::Break> breaks;
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
    const auto& nodes = tetrahedra[t];
    if (cut_of[t] < 0) {
      const bool touches =
          std::any_of(nodes.begin(), nodes.end(), [&](auto node) { return at_crack[index(node)] != 0; });
      const bool breaks_too = touches ? cutting.touching > 0 && random.uniform() < cutting.touching
                                      : cutting.is_stray && cutting.is_stray(centroid[t], random);
      if (!breaks_too) continue;
    }
    const bool is_random = cut_of[t] < 0 || random.uniform() < cutting.random_cuts;
    const auto any = static_cast<std::int32_t>(random.uniform() * fracture::n_cuts);
    breaks.push_back({static_cast<std::int64_t>(t), 0, cutting.time ? cutting.time(centroid[t]) : 0, 1, 1,
                      is_random ? any : cut_of[t]});
  }
  std::ranges::stable_sort(breaks, {}, &fracture::Break::phase_time);
  return cracks::make_crack_surface(body, realization, breaks, 0);
}

}  // namespace crackle::test
