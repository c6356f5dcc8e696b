// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/geometry/point.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace crackle::geometry {

/// The regions of the mesh, each as far as it lies in the bounds.
std::vector<SpacingSource> region_sources(const input::Mesh& mesh, const Box& bounds);

/// The target distance between neighbouring mother points: `notch_spacing` at a notch tip and the spacing of
/// a region in its box, growing with `growth` per unit distance from either up to `spacing`.
///
/// Where the body itself is finer (Body::spacing_sources), the spacing follows it, because Delaunay
/// tetrahedra conform to a face only if its points are about as close to each other as to the next face: at
/// most the height and the depth of a slot on its walls, at most the clear distance between two notches or
/// between a notch and a parallel or opposite face, at most the smallest size of the body. From there it
/// grows with the larger of `growth` and 0.2.
class SpacingField {
public:
  SpacingField(const Body& body, const input::Mesh& mesh);

  double operator()(const Point& p) const;      ///< [m]
  double lower_bound(const Box& region) const;  ///< a bound over a box, sharp for small ones [m]
  double upper_bound(const Box& region) const;  ///< a bound over a box [m]
  double largest_growth() const;                ///< bound of the change per distance

  /// For messages: the smallest spacing and what asks for it, and the largest one.
  std::string range_text() const;

private:
  double far_;
  std::vector<SpacingSource> sources_;
};

/// The base distribution: one per ensemble, or one per sample with `mesh.base` own; in slab order along the
/// longest edge of the body.
///
/// `movable` tells in which directions a point may be disturbed (Body::movable): one in the interior in all
/// three, one in a face in two, one on an edge in one, a corner in none. So the disturbance keeps the
/// geometry.
struct MotherPoints {
  std::vector<Point> position;  ///< [m]
  std::vector<double> spacing;  ///< target spacing at the point [m]
  std::vector<std::uint8_t> movable;
  std::size_t size() const { return position.size(); }
};

/// The number of mother points that make_mother_points would place, to a few percent; cheap. Numbers over
/// input::max_mother_points, which that refuses, are lower bounds.
/// @throws std::runtime_error where an edge is more than a million spacings long
double estimate_n_points(const Body& body, const input::Mesh& mesh);

/// The same. @throws std::runtime_error where make_mother_points refuses this number, too
double checked_n_points(const Body& body, const input::Mesh& mesh);

/// Graded blue noise in the body: corners, then edges, surfaces and interior by weighted sample elimination
/// from random candidates, improved by a few rounds of optimal Delaunay triangulation that keep the geometry,
/// then by local moves until every tetrahedron of the tessellation has a good shape and conforms to the body.
///
/// Deterministic: depends on the body, the mesh parameters and the seed only, with `mesh.base` own also on
/// sample and attempt. With `mesh.points` the points
/// come from that file (read_points), and only points at tetrahedra that do not conform or fall below
/// `min_quality` are moved.
/// @param expects is called with the expected number of points before they are placed
/// @param sample whose points these are, and its attempt: without effect unless `mesh.base` is own
/// @throws std::runtime_error naming the reason where the body cannot be meshed with this spacing and
/// quality,
///   or would take more than 2e7 points
MotherPoints make_mother_points(const Body& body, const input::Mesh& mesh, std::uint64_t seed,
                                const std::function<void(double n_points)>& expects = {},
                                std::uint64_t sample = 0, int attempt = 0);

/// Reads mother points from a text file: one point "x y z" in millimetres per line, separated by blanks or
/// commas; text after '#' and empty lines are skipped. A point within 1e-9 of the body's largest size of the
/// surface is set exactly on it (Body::snapped), so points in faces, on edges and at corners are recognized.
/// Points that are nearer than that to each other are duplicates. Every corner of the body must be among the
/// points.
/// @return positions in the order of the file [m]
/// @throws std::runtime_error with "file:line: reason" for each bad line (at most 20), point outside the body
/// or
///   duplicate; or naming a missing corner
std::vector<Point> read_points(const std::filesystem::path& file, const Body& body);

}  // namespace crackle::geometry
