// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/complex.h"
#include "geometry/realization.h"
#include "plane/plate.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

/// Cracks that are there before any load. They open the dual facets between the nodes on their two sides, as
/// breaking does.
namespace crackle::geometry {

/// Two unit vectors across a direction of length 1 and each other. The first is the shadow of that coordinate
/// axis which is most perpendicular to it, the first of several.
std::array<Vector, 2> across(const Vector& direction);

/// How a pre-crack opens a tetrahedron, as in Realization::pre_crack.
struct PreCrackCut {
  std::int32_t crack;  ///< its number
  int cut;             ///< as fracture::Break::cut

  std::int32_t code() const { return 1 + 8 * crack + cut; }
  /// @pre code > 0: no crack opens a tetrahedron with 0
  static PreCrackCut from(std::int32_t code) { return {(code - 1) / 8, (code - 1) % 8}; }
};

/// The plane figure of one pre-crack.
class PreCrackFigure {
public:
  /// @param bounds of the body, through whose thickness a crack between two points runs
  PreCrackFigure(const plane::PreCrack& crack, const Box& bounds);

  /// A rectangle in its plane that contains it; the third own axis is the normal.
  const Patch& patch() const { return patch_; }
  /// Its border as a closed line of chords [m].
  const std::vector<Point>& border() const { return border_; }
  double height(const Point& p) const { return patch_.own(p)[2]; }  ///< above its plane [m]
  const Vector& normal() const { return patch_.axes[2]; }           ///< unit vector
  /// True for a point of its plane within the figure.
  bool holds(const Point& p) const;

  /// The cut of a tetrahedron with corners on both sides of the plane if the crack reaches the middle of what
  /// the plane cuts of it, or -1: the area opened is that of the crack, on average.
  int cut(const std::array<Point, 4>& corners) const;

private:
  Patch patch_;
  std::vector<Point> border_;
  plane::Polygon own_border_;
  plane::Point semi_axes_{};  // of an ellipse; 0: the border counts
};

/// Realization::pre_crack: of several cracks through a tetrahedron the first one opens it.
std::vector<std::int32_t> pre_crack_cuts(const Realization& realization,
                                         std::span<const plane::PreCrack> cracks, const Box& bounds);

/// Gives a realization its pre-cracks.
void open_pre_cracks(std::span<const plane::PreCrack> cracks, const Box& bounds, Realization& realization);

/// Gives a complex the starts of its pre-cracks, crack-0 and so on, and one of all random flaws: after those
/// of notches and holes. Along the fronts mesh.notch_spacing holds.
void add_pre_cracks(Complex& complex, const input::Model& model);

}  // namespace crackle::geometry
