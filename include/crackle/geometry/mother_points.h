// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/geometry/point.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <vector>

namespace crackle::geometry {

/// The target distance between neighbouring mother points: `notch_spacing` at a notch tip, growing with
/// `growth` per unit distance up to `spacing`.
class SpacingField {
public:
  SpacingField(const Body& body, const input::Mesh& mesh);
  double operator()(const Point& p) const;

private:
  const Body* body_;
  double far_, tip_, growth_;
};

/// The base distribution: one per ensemble, in slab order along the longest edge of the body.
///
/// Bit i of `movable` is set where coordinate i may be disturbed: a point in the interior has all three bits,
/// one on a plane of the body two, one on an edge one, a corner none. So the disturbance keeps the geometry.
struct MotherPoints {
  std::vector<Point> position;  ///< [m]
  std::vector<double> spacing;  ///< target spacing at the point [m]
  std::vector<std::uint8_t> movable;
  std::size_t size() const { return position.size(); }
};

/// Graded blue noise in the body, dense enough on the notch walls that Delaunay tetrahedra conform to them.
/// Deterministic: depends on the body, the mesh parameters and the seed only. With `mesh.points` the points
/// come from that file.
/// @throws std::runtime_error naming the reason where the body cannot be meshed with this spacing
MotherPoints make_mother_points(const Body& body, const input::Mesh& mesh, std::uint64_t seed);

}  // namespace crackle::geometry
