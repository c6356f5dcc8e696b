// SPDX-License-Identifier: GPL-3.0-or-later
#include "halo.h"

#include "crackle/common/index.h"
#include "crackle/geometry/centroid.h"

#include <algorithm>
#include <cmath>

namespace crackle::geometry {

std::size_t Halo::CellHash::operator()(const Cell& cell) const {
  std::uint64_t hash = 0;
  for (const auto i : cell) hash = (hash ^ static_cast<std::uint64_t>(i)) * 0x9E3779B97F4A7C15U;
  return hash ^ (hash >> 32);
}

Halo::Halo(const Realization& realization, const Partition& partition, double width) : width_(width) {
  std::unordered_map<Cell, std::vector<std::int32_t>, CellHash> inside;
  for (const Tetrahedron& t : realization.tetrahedra) {
    auto& parts = inside[cell_of(centroid(realization.nodes, t))];
    const std::int32_t part = partition.node_part[index(t[0])];
    if (std::ranges::find(parts, part) == parts.end()) parts.push_back(part);
  }
  near_.reserve(inside.size());
  for (const auto& [cell, ignored] : inside) {
    auto& parts = near_[cell];
    for (const std::int64_t i : {-1, 0, 1})
      for (const std::int64_t j : {-1, 0, 1})
        for (const std::int64_t k : {-1, 0, 1}) {
          const auto other = inside.find({cell[0] + i, cell[1] + j, cell[2] + k});
          if (other != inside.end()) parts.insert(parts.end(), other->second.begin(), other->second.end());
        }
    std::ranges::sort(parts);
    parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
  }
}

std::span<const std::int32_t> Halo::parts_near(const Point& place) const {
  return near_.at(cell_of(place));
}

Halo::Cell Halo::cell_of(const Point& place) const {
  Cell cell{};
  for (std::size_t i = 0; i < 3; ++i) cell[i] = static_cast<std::int64_t>(std::floor(place[i] / width_));
  return cell;
}

}  // namespace crackle::geometry
