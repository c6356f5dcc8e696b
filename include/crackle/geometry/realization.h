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
  FaceId surface;
};

/// What making a realization took; the same on every machine.
struct RealizationReport {
  int rounds = 0;                   ///< rounds of local redrawing
  std::int64_t redrawn_points = 0;  ///< points drawn at least once more
  double min_quality = 0;           ///< mean-ratio quality of the worst tetrahedron
  int attempt = 0;                  ///< that succeeded; those before it used other random numbers
  std::uint8_t symmetry = 0;        ///< code of the Symmetry by which it is set into the body
};

/// One conforming tessellation of the body. Its nodes keep the numbers of the base mother points. Tetrahedra
/// are positively oriented, with their smallest node first and the smallest of the others second, in
/// ascending order of their sorted nodes; triangles have their smallest node first and are in ascending
/// order. So all numbers depend on (input, seed, sample) only.
struct Realization {
  std::vector<Point> nodes;  ///< [m]
  std::vector<Tetrahedron> tetrahedra;
  std::vector<BoundaryTriangle> boundary;
  RealizationReport report;
};

/// Disturbs the base points, tessellates them (Delaunay, CGAL) and redraws points locally until the
/// realization fills the body exactly and every tetrahedron keeps the minimum quality.
///
/// A point is displaced uniformly in the ball of radius perturbation x spacing, in its surface or along its
/// edge; a redrawn point likewise, the next draw of its own stream that gives good tetrahedra being taken.
/// Only where a spot resists many draws does the radius shrink, in the end to the base position. With
/// perturbation 0 the nodes are the base points. Takes less than twice the time of the tessellation alone.
///
/// One base distribution is not the same at equivalent places of the body, such as two equal notches, and a
/// small disturbance leaves it so. With `mesh.turn` random and a perturbation the finished realization is
/// therefore set into the body by one of the symmetries that body and mesh regions share, each with the same
/// probability, from the stream (seed, sample, "turn").
/// @param base points whose own tessellation conforms, as make_mother_points gives them
/// @param sample selects the random stream (seed, sample, "disturbance")
/// @param attempt others than 0 take a stream of their own, for a sample that could not be made
/// @throws std::runtime_error when the redrawing does not end within 200 rounds (some 1 to 5 are usual), or
/// the
///   result fails verify()
Realization make_realization(const Body& body, const MotherPoints& base, const input::Mesh& mesh,
                             std::uint64_t seed, std::uint64_t sample, int attempt = 0);

/// Checks everything that a realization promises: every node is used; tetrahedra have a positive volume, at
/// least the minimum quality, and none reaches out of the body; their volumes add up to the body's to 1e-12
/// relative; faces match in pairs of opposite orientation except those listed as boundary; boundary triangles
/// lie bit by bit in their face (Body::in_face), look outwards, and cover each face to 1e-12 relative.
/// @return quality of the worst tetrahedron
/// @throws std::runtime_error naming the first violation with its figures
double verify(const Realization& realization, const Body& body, double min_quality);

}  // namespace crackle::geometry
