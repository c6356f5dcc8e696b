// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"

#include <array>

namespace crackle::cracks {

/// The direction in which cracks are seen, and the plane on which they are followed: here through the
/// thickness of a plate, on its mid-plane. Nothing else that follows cracks knows these directions.
class Projection {
public:
  explicit Projection(const geometry::Body& body)
      : thickness_(body.size()[0]), width_(body.size()[1]), side_(body.bounds().lower[1]) {}

  double thickness() const { return thickness_; }  ///< of the body, in the direction of view [m]
  double width() const { return width_; }          ///< of the body, as it is seen [m]
  /// The plane across the width at a share part / of.
  geometry::CrossPlane at_width(double part, double of) const {
    return geometry::plane_of({1, side_ + width_ * part / of});
  }
  static double depth(const geometry::Point& p) { return p[0]; }
  static std::array<double, 2> in_plane(const geometry::Point& p) { return {p[1], p[2]}; }
  /// The point of the plane that is seen where p is.
  geometry::Point projected(const geometry::Point& p) const { return {thickness_ / 2, p[1], p[2]}; }
  /// The unit vector of the plane perpendicular to one.
  static Vector across(const Vector& along) { return {0, -along[2], along[1]}; }
  /// True if a face's normal is the direction of view.
  static bool faces(const Vector& normal) { return !(std::abs(normal[0]) < 0.5); }

private:
  double thickness_, width_, side_;
};

}  // namespace crackle::cracks
