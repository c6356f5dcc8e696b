// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"
#include "input/model.h"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace crackle::geometry {

/// The part of one face on which a boundary condition acts: a rectangle along the face's own axes, a line if
/// it has no extent along one of them, a point if it has none at all. Of a face that is level with none of
/// the axes that limit the region, the part of the face, or of a line in it, within these limits.
struct FacePart {
  FaceId face;
  Patch patch;                      ///< of the face
  std::array<std::size_t, 2> axis;  ///< own axes of the patch that span the face
  std::array<double, 2> lower;      ///< own coordinates along these axes [m]
  std::array<double, 2> upper;
  double tolerance;                          ///< a point of the face within this distance is included [m]
  plane::Region limits = plane::everywhere;  ///< of the part, beside the rectangle

  bool has_limit(std::size_t axis) const { return limits[axis] != plane::unbounded; }
  bool has_limits() const { return has_limit(0) || has_limit(1) || has_limit(2); }
  int n_dimensions() const;
  /// @param p a point of the face
  bool contains(const Point& p) const;
};

/// The region of a boundary condition: equal in every realization, since the borders of its parts are edges
/// of the mesh (imprint.h).
struct ConditionRegion {
  std::vector<FacePart> parts;  ///< by ascending face, all of the same dimension
  int n_dimensions = 2;         ///< 2: areas, 1: lines, 0: points

  /// The part on a face, or nullptr.
  const FacePart* on(FaceId face) const;
};

/// The part of the named faces inside the region of a condition, with borders moved onto edges of the body
/// that are closer than 1e-6 of the body's size.
/// @throws std::runtime_error when nothing is left
ConditionRegion condition_region(const Body& body, const input::Boundary& condition, std::size_t number);

/// The regions of all conditions of an input, in their order.
std::vector<ConditionRegion> condition_regions(const Body& body, std::span<const input::Boundary> conditions);

/// The lines and points at which cylinders and spheres touch level faces: nodes lie on them in every
/// realization.
std::vector<ConditionRegion> touched_regions(const Body& body, std::span<const input::Tool> tools);

/// A condition whose region requires a finer mesh than the rest of the input.
struct RegionRefinement {
  std::size_t condition;
  double spacing;  ///< finest spacing required [m]
};

std::vector<RegionRefinement> region_refinements(const input::Model& model);

}  // namespace crackle::geometry
