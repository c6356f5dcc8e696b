// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "common/random.h"
#include "geometry/partition.h"
#include "geometry/realization.h"

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

namespace crackle::test {

using MakePartition = std::function<geometry::Partition(const geometry::Realization& mesh, int n_parts)>;

struct NamedPartition {
  const char* name;
  MakePartition make;
};

/// Assigns each tetrahedron to a part from its centre, its number and the number of parts.
inline MakePartition by_position(const std::function<int(const geometry::Point&, std::size_t, int)>& part) {
  return [part](const geometry::Realization& mesh, int n_parts) {
    std::vector<std::int32_t> parts;
    for (const auto& t : mesh.tetrahedra) {
      geometry::Point centre{};
      for (const auto node : t)
        for (std::size_t i = 0; i < 3; ++i) centre[i] += 0.25 * mesh.nodes[index(node)][i];
      parts.push_back(part(centre, parts.size(), n_parts));
    }
    return geometry::partition_of(mesh, std::move(parts), n_parts);
  };
}

/// METIS partitions and others that no partitioner would make, of a box that starts at the origin.
inline std::vector<NamedPartition> hostile_partitions(const geometry::Point& size) {
  const auto slab = [size](const geometry::Point& p, std::size_t axis, int n) {
    return std::min(n - 1, static_cast<int>(n * p[axis] / size[axis]));
  };
  return {
      {"across the axis", by_position([slab](const auto& p, std::size_t, int n) { return slab(p, 2, n); })},
      {"along the axis", by_position([slab](const auto& p, std::size_t, int n) { return slab(p, 1, n); })},
      {"disconnected", by_position([slab](const auto& p, std::size_t, int n) { return slab(p, 2, 14) % n; })},
      {"scattered", by_position([](const auto&, std::size_t t, int n) {
         auto stream = RandomStream(7, 0, "parts").substream(t);
         return std::min(n - 1, static_cast<int>(stream.uniform(0, n)));
       })},
      {"all on the last", by_position([](const auto&, std::size_t, int n) { return n - 1; })},
      {"one tetrahedron each but for the first", by_position([](const auto&, std::size_t t, int n) {
         return t < static_cast<std::size_t>(n) ? static_cast<int>(t) : 0;
       })},
      {"another seed", [](const auto& mesh, int n) { return geometry::partition(mesh, n, 1234); }},
  };
}

}  // namespace crackle::test
