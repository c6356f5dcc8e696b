// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/geometry/mother_points.h"
#include "crackle/geometry/point.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <vector>

namespace crackle::geometry {

/// A triangle of the body's boundary, oriented with its normal outwards.
struct BoundaryTriangle {
  Triangle nodes;
  SurfaceId surface;
};

/// What making a realization took; the same on every machine.
struct RealizationReport {
  int rounds = 0;                   ///< rounds of local redrawing
  std::int64_t redrawn_points = 0;  ///< points drawn at least once more
  double min_quality = 0;           ///< mean-ratio quality of the worst tetrahedron
};

/// One conforming tessellation of the body. Its nodes keep the numbers of the base mother points; its
/// tetrahedra are positively oriented, with ascending order of their sorted nodes, so that node, tetrahedron
/// and triangle numbers depend on (input, seed, sample) only.
struct Realization {
  std::vector<Point> nodes;  ///< [m]
  std::vector<Tetrahedron> tetrahedra;
  std::vector<BoundaryTriangle> boundary;
  RealizationReport report;
};

/// Disturbs the base points, tessellates them (CGAL) and redraws points locally until the realization fills
/// the body exactly and every tetrahedron keeps the minimum quality.
/// @param sample selects the random stream (seed, sample, "disturbance")
/// @throws std::runtime_error when the redrawing does not end within its documented number of rounds
Realization make_realization(const Body& body, const MotherPoints& base, const input::Mesh& mesh,
                             std::uint64_t seed, std::uint64_t sample);

/// Checks everything that a realization promises (design: volume to 1e-12 relative, boundary triangles
/// exactly on the planes of the body, areas, no tetrahedron across a notch, minimum quality).
/// @return quality of the worst tetrahedron
/// @throws std::runtime_error naming the first violation with its figures
double verify(const Realization& realization, const Body& body, double min_quality);

}  // namespace crackle::geometry
