// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"
#include "geometry/crew.h"
#include "geometry/point.h"
#include "input/model.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace crackle::geometry {

/// The regions of the mesh, clipped to the bounds.
std::vector<SpacingSource> region_sources(const input::Mesh& mesh, const Box& bounds);

/// The target distance between neighbouring mother points: `notch_spacing` at a notch tip and the spacing of
/// a region in its box, growing with `growth` per unit distance from either up to `spacing`.
///
/// Near small features of the body (Body::spacing_sources) the spacing is reduced, because Delaunay
/// tetrahedra conform to a face only if its points are about as close to each other as to the next face. It
/// is at most the height and the depth of a slot on its walls, the clear distance between two notches or
/// between a notch and a parallel or opposite face, and the smallest size of the body. From there it grows
/// with the larger of `growth` and 0.2.
class SpacingField {
public:
  SpacingField(const Body& body, const input::Mesh& mesh);
  /// @param sources in addition to the regions of the mesh
  SpacingField(const Box& bounds, const input::Mesh& mesh, const std::vector<SpacingSource>& sources);

  double operator()(const Point& p) const;      ///< [m]
  double lower_bound(const Box& region) const;  ///< a bound over a box, sharp for small ones [m]
  double upper_bound(const Box& region) const;  ///< a bound over a box [m]
  double largest_growth() const;                ///< bound on the change per unit distance

  /// The source of the smallest spacing; null where none makes the mesh finer.
  const SpacingSource* finest() const;
  /// For messages: the smallest spacing with its reason, and the largest one.
  std::string range_text() const;

private:
  void make_grid(const Box& bounds);

  double far_;
  std::vector<SpacingSource> sources_;
  // Of many sources, those that may give the spacing in each cell of a grid over the body.
  Box bounds_{};
  std::vector<std::vector<std::int32_t>> of_cell_;
};

/// The base distribution: one per ensemble, or one per sample with mesh.base = "own"; in slab order along the
/// longest edge of the body.
///
/// `movable` gives the directions in which a point may be perturbed (Body::movable): three in the interior,
/// two in a face, one on an edge, none at a corner. Thus the perturbation preserves the geometry.
struct MotherPoints {
  std::vector<Point> position;  ///< [m]
  std::vector<double> spacing;  ///< target spacing at the point [m]
  std::vector<std::uint8_t> movable;
  std::size_t size() const { return position.size(); }
};

/// The number of mother points that make_mother_points would place, to a few percent; cheap. Numbers above
/// input::max_mother_points, which make_mother_points refuses, are lower bounds.
/// @throws std::runtime_error when an edge is more than a million spacings long
double estimate_n_points(const Body& body, const input::Mesh& mesh);

/// The same. @throws std::runtime_error also when make_mother_points would refuse this number
double checked_n_points(const Body& body, const input::Mesh& mesh);

/// Graded blue noise in the body: corners, then points on edges, in faces and in the interior at random in
/// the required density, whose distances a short-range repulsion makes even; improved by local moves until
/// every tetrahedron of the tessellation has a good shape and conforms to the body.
///
/// Deterministic: depends only on the body, the mesh parameters and the seed and, with mesh.base = "own", on
/// sample and attempt. With `mesh.points` the points come from that file (read_points), and only points of
/// tetrahedra that do not conform or fall below `min_quality` are moved.
/// @param expects is called with the expected number of points before they are placed
/// @param sample, attempt no effect unless mesh.base = "own"
/// @param crew workers that help to place the points, of which this one leads; null: none
/// @throws std::runtime_error naming the reason when the body cannot be meshed with this spacing and quality,
///   or would need more than 2e7 points
MotherPoints make_mother_points(const Body& body, const input::Mesh& mesh, std::uint64_t seed,
                                const std::function<void(double n_points)>& expects = {},
                                std::uint64_t sample = 0, int attempt = 0, Crew* crew = nullptr);

/// The part of the other workers of a crew, with the regions that Crew::run gives them. Collective over them.
void help_mother_points(const Body& body, const input::Mesh& mesh, std::uint64_t seed, std::uint64_t sample,
                        int attempt, Crew& crew);

/// Reads mother points from a text file: one point "x y z" in millimetres per line, separated by blanks or
/// commas; text after '#' and empty lines are skipped. A point within 1e-9 of the body's largest size of the
/// surface is moved exactly onto it (Body::snapped), so points in faces, on edges and at corners are
/// recognized. Points closer than that to each other are duplicates. Every corner of the body must be among
/// the points.
/// @return positions in the order of the file [m]
/// @throws std::runtime_error with "file:line: reason" for each bad line (at most 20), point outside the body
/// or
///   duplicate; or naming a missing corner
std::vector<Point> read_points(const std::filesystem::path& file, const Body& body);

}  // namespace crackle::geometry
