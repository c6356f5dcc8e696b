// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/realization.h"

#include <vector>

namespace crackle::geometry {

/// Minimum, 1 % quantile, median and maximum.
struct Quantiles {
  double smallest = 0;
  double one_percent = 0;
  double median = 0;
  double largest = 0;
};

/// All 0 without values.
Quantiles quantiles(std::vector<double> values);

/// Figures that describe a realization.
struct MeshStatistics {
  Quantiles edge_length;      ///< over the edges, each once [m]
  Quantiles quality;          ///< mean ratio, over the tetrahedra
  double smallest_angle = 0;  ///< dihedral [rad]
  double largest_angle = 0;   ///< dihedral [rad]
  std::int64_t n_edges = 0;
};

MeshStatistics mesh_statistics(const Realization& realization);

/// The tetrahedra of one material.
struct MaterialContents {
  std::int64_t tetrahedra = 0;
  double volume = 0;  ///< [m^3]
};

/// By the materials' numbers, up to the last one that the realization has; empty if the body has only one.
std::vector<MaterialContents> material_contents(const Realization& realization);

}  // namespace crackle::geometry
