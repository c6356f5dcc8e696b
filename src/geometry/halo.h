// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/partition.h"
#include "crackle/geometry/realization.h"

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace crackle::geometry {

/// Finds the parts with tetrahedra near a point.
class Halo {
public:
  /// @param width [m]
  Halo(const Realization& realization, const Partition& partition, double width);

  /// All parts that own the first node of a tetrahedron whose centroid is closer to `place` than the width,
  /// and possibly some less than 2 sqrt(3) widths away; ascending.
  std::span<const std::int32_t> parts_near(const Point& place) const;

private:
  using Cell = std::array<std::int64_t, 3>;
  struct CellHash {
    std::size_t operator()(const Cell& cell) const;
  };
  Cell cell_of(const Point& place) const;

  double width_;
  std::unordered_map<Cell, std::vector<std::int32_t>, CellHash> near_;  // by cell containing a centroid
};

}  // namespace crackle::geometry
