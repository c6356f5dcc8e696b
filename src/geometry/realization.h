// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"
#include "geometry/mother_points.h"
#include "geometry/point.h"
#include "input/model.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::geometry {

/// A triangle of the body's boundary, oriented with its normal outwards.
struct BoundaryTriangle {
  Triangle nodes;
  FaceId surface;
};

/// Work of making a realization; equal on every machine.
struct RealizationReport {
  int rounds = 0;                   ///< rounds of local redrawing
  std::int64_t redrawn_points = 0;  ///< for good cells, and for a longer step
  double min_quality = 0;           ///< mean-ratio quality of the worst tetrahedron
  int attempt = 0;                  ///< the successful one; earlier attempts used other random numbers
  std::uint8_t symmetry = 0;        ///< code of the Symmetry applied
};

/// One conforming tessellation of the body. Its nodes keep the numbers of the base mother points. Tetrahedra
/// are positively oriented, with their smallest node first and the smallest of the others second, in
/// ascending order of their sorted nodes; triangles have their smallest node first and are in ascending
/// order. Thus all numbers depend on (input, seed, sample) only.
struct Realization {
  std::vector<Point> nodes;  ///< [m]
  std::vector<Tetrahedron> tetrahedra;
  std::vector<BoundaryTriangle> boundary;
  /// Material of each tetrahedron, as its number in Model::materials; empty if the body has only one.
  std::vector<std::uint8_t> material = {};
  /// 1 + the number in Model::interfaces of that to which each tetrahedron belongs, the first of
  /// several: it is of one of its two materials and has a node where these meet. 0: none; empty without
  /// interfaces.
  std::vector<std::uint8_t> interface = {};
  std::vector<float> map_factor = {};  ///< of each tetrahedron by the input's raster; empty without one
  /// Of each tetrahedron the pre-crack that opens it, see PreCrackCut; empty without any.
  std::vector<std::int32_t> pre_crack = {};
  std::vector<Vector> pre_crack_normal = {};  ///< of each pre-crack's plane, unit vector
  RealizationReport report;
};

/// Calls work(array) for each array of a Realization, or those that a Subdomain has in common with it.
template <class Mesh, class Work>
void for_each_array(Mesh& mesh, const Work& work) {
  work(mesh.nodes);
  work(mesh.tetrahedra);
  work(mesh.boundary);
  work(mesh.material);
  work(mesh.interface);
  work(mesh.map_factor);
  work(mesh.pre_crack);
  work(mesh.pre_crack_normal);
}

/// Perturbs the base points, tessellates them (Delaunay, CGAL) and redraws points locally until the
/// realization fills the body exactly and every tetrahedron has the minimum quality.
///
/// A point is displaced uniformly within a ball of radius perturbation x spacing, within its surface or along
/// its edge. A redrawn point takes the next draw of its own stream that gives good tetrahedra; only if many
/// draws fail does the radius shrink, ultimately to the base position. With perturbation 0 the nodes are the
/// base points. Finally the few nodes that would decide the stable step are redrawn, see redraw_stiffest.h.
/// Takes less than twice the time of the tessellation alone.
///
/// A single base distribution differs between equivalent places of the body, such as two equal notches, and a
/// small perturbation does not remove this bias. Therefore, with mesh.symmetry = "random" and a perturbation,
/// the finished realization is transformed by one of the common symmetries of body and mesh regions, with
/// equal probabilities, from the stream (seed, sample, "turn").
/// @param base points whose own tessellation conforms, as from make_mother_points
/// @param sample selects the random stream (seed, sample, "disturbance")
/// @param attempt values other than 0 select separate streams, for retries
/// @throws std::runtime_error when redrawing does not succeed within 200 rounds (1 to 5 are usual), or the
///   result fails verify()
Realization make_realization(const Body& body, const MotherPoints& base, const input::Mesh& mesh,
                             std::uint64_t seed, std::uint64_t sample, int attempt = 0);

/// Checks all invariants of a realization: every node is used; tetrahedra have positive volume, at least the
/// minimum quality, and do not extend beyond the body; their volumes add up to the body's to 1e-12 relative;
/// faces match in pairs of opposite orientation except those listed as boundary; boundary triangles lie
/// exactly in their face (Body::in_face), are oriented outwards, and cover each face to 1e-12 relative; each
/// material has its volume to 1e-12 relative, or to 1e-15 of the body's.
/// @return quality of the worst tetrahedron
/// @throws std::runtime_error naming the first violation with its figures
double verify(const Realization& realization, const Body& body, double min_quality);

/// Realization::interface, from the other members.
/// @param pairs of materials
std::vector<std::uint8_t> interface_numbers(const Realization& realization,
                                            std::span<const std::array<int, 2>> pairs);

}  // namespace crackle::geometry
