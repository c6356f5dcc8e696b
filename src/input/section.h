// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/vector.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace crackle::input {

/// A straight line in the y-z plane.
struct SectionLine {
  std::array<double, 2> from{};  ///< y, z [m]
  std::array<double, 2> to{};
  bool operator==(const SectionLine&) const = default;
};

/// A plane anywhere in space, in which the traces of cracks are measured.
struct SectionPlane {
  Vector point{};   ///< [m]
  Vector normal{};  ///< of any length
  bool operator==(const SectionPlane&) const = default;
};

/// A plane through the thickness at which crack paths are measured: y = const, z = const, or through a line.
struct Section {
  int axis = 0;         ///< 1: y, 2: z, 0: a line
  double position = 0;  ///< of the plane, along that axis [m]; 0 for a line
  SectionLine line{};   ///< of a line
  bool operator==(const Section&) const = default;
};

struct Sections {
  std::vector<double> y;  ///< [m], ascending
  std::vector<double> z;  ///< likewise
  std::vector<SectionLine> lines = {};
  std::vector<SectionPlane> planes = {};

  /// Of all but the planes, which measure no paths.
  std::size_t size() const { return y.size() + z.size() + lines.size(); }
  /// In numbering order: y first, then z, then lines.
  std::vector<Section> all() const;
};

/// "y = 12.25 mm", "line from (1 mm, 2 mm) to (3 mm, 4 mm)"
std::string name_of(const Section& section);

/// Name of the coordinate along the section: "z", "y", or "distance" from a line's start.
const char* coordinate_of(const Section& section);

}  // namespace crackle::input
