// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "plane/plate.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace crackle::plane {

/// Regions closer than this share of the body's size touch.
inline constexpr double region_merging = 1e-6;

/// Where the materials of a specimen meet: layers between levels of x, divided in the plane of the plate by
/// straight lines.
struct MaterialLayout {
  /// A line between two corners.
  struct Line {
    std::array<int, 2> end;  ///< corners; the plate lies to the left of a line on its boundary
    int side;                ///< of the plate on which it lies, counted over all loops; -1 inside the plate
    int region;              ///< whose outline it is, the last of several; -1 if of none
    std::vector<int> left;   ///< region of each layer on the left; -1: none
    std::vector<int> right;  ///< on the right; that of a line on the boundary is without meaning
  };

  std::vector<double> levels;   ///< of x, from 0 to the thickness [m]
  std::vector<Point> corners;   ///< those of the plate first, in the order of its loops
  std::vector<Line> lines;      ///< on the boundary of the plate, and where two materials meet
  std::vector<Polygon> region;  ///< outline of each one, with the corners of the lines on it
  std::vector<int> material;    ///< of each region
  std::vector<std::vector<std::uint8_t>> fills;  ///< per layer, whether each region extends through it

  std::size_t n_layers() const { return levels.size() - 1; }
  /// The region on one side of a line, in a layer.
  static int region_beside(const Line& line, bool on_left, std::size_t layer) {
    return (on_left ? line.left : line.right)[layer];
  }
  /// The number of a region's material.
  int material_of(int region) const { return region < 0 ? 0 : material[static_cast<std::size_t>(region)]; }
  /// True if a line in the plate parts two materials in this layer.
  bool is_wall(const Line& line, std::size_t layer) const {
    return line.side < 0 && material_of(line.left[layer]) != material_of(line.right[layer]);
  }
  /// Area of a part of the plate [m^2].
  /// @param belongs of a line and whether its left or its right side is meant; not called for what is outside
  template <class Belongs>
  double area(const Belongs& belongs) const {
    const Point& origin = corners.front();
    double twice = 0;
    for (const Line& line : lines) {
      const int sign =
          static_cast<int>(belongs(line, true)) - static_cast<int>(line.side < 0 && belongs(line, false));
      if (sign != 0)
        twice += sign * cross(corners[index(line.end[0])] - origin, corners[index(line.end[1])] - origin);
    }
    return twice / 2;
  }
};

/// @pre the regions have outlines; the specimen has a shape
/// @param all keeps lines between regions of one material
/// @throws std::runtime_error when regions are too small to be told apart
MaterialLayout material_layout(const Specimen& specimen, bool all = false);

}  // namespace crackle::plane
