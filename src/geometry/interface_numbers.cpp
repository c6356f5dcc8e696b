// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/geometry/interface_numbers.h"

#include "crackle/common/index.h"
#include "crackle/geometry/face_neighbours.h"

#include <algorithm>
#include <map>
#include <set>

namespace crackle::geometry {

namespace {

/// True for the nodes of tetrahedra of several materials.
std::vector<std::uint8_t> nodes_between(const Realization& realization) {
  std::vector<int> first(realization.nodes.size(), -1);
  std::vector<std::uint8_t> result(realization.nodes.size(), 0);
  for (std::size_t i = 0; i < realization.tetrahedra.size(); ++i)
    for (const std::int32_t node : realization.tetrahedra[i]) {
      int& known = first[index(node)];
      if (known < 0) known = realization.material[i];
      if (known != realization.material[i]) result[index(node)] = 1;
    }
  return result;
}

/// The pairs of materials that meet in faces at each node.
std::map<std::int32_t, std::set<std::size_t>> pairs_at_nodes(const Realization& realization,
                                                             std::span<const std::array<int, 2>> pairs) {
  const std::vector<std::uint8_t> is_between = nodes_between(realization);
  std::vector<Tetrahedron> near;
  std::vector<int> material;
  for (std::size_t i = 0; i < realization.tetrahedra.size(); ++i) {
    const Tetrahedron& t = realization.tetrahedra[i];
    if (std::ranges::count_if(t, [&](std::int32_t node) { return is_between[index(node)] != 0; }) < 3)
      continue;
    near.push_back(t);
    material.push_back(realization.material[i]);
  }
  const auto neighbours = face_neighbours(near);
  std::map<std::int32_t, std::set<std::size_t>> result;
  for (std::size_t i = 0; i < near.size(); ++i)
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      const std::int32_t other = neighbours[i][opposite];
      if (other < 0 || material[index(other)] == material[i]) continue;
      const std::array<int, 2> own{material[i], material[index(other)]};
      for (std::size_t pair = 0; pair < pairs.size(); ++pair)
        for (std::size_t k = 0; k < 4 && std::ranges::is_permutation(pairs[pair], own); ++k)
          if (k != opposite) result[near[i][k]].insert(pair);
    }
  return result;
}

}  // namespace

std::vector<std::uint8_t> interface_numbers(const Realization& realization,
                                            std::span<const std::array<int, 2>> pairs) {
  const auto at_nodes = pairs_at_nodes(realization, pairs);
  std::vector<std::uint8_t> result(realization.tetrahedra.size(), 0);
  for (std::size_t i = 0; i < result.size(); ++i) {
    std::size_t first = pairs.size();
    for (const std::int32_t node : realization.tetrahedra[i]) {
      const auto found = at_nodes.find(node);
      if (found == at_nodes.end()) continue;
      for (const std::size_t pair : found->second)
        if (std::ranges::find(pairs[pair], int{realization.material[i]}) != pairs[pair].end())
          first = std::min(first, pair);
    }
    if (first < pairs.size()) result[i] = static_cast<std::uint8_t>(first + 1);
  }
  return result;
}

}  // namespace crackle::geometry
