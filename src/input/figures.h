// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "findings.h"
#include "input/parameters.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

/// Figures in the plane of the plate: holes and regions.
namespace crackle::input {

/// The point distance required by the mesh, regardless of the body's shape.
class MeshSpacing {
public:
  explicit MeshSpacing(const Parameters& parameters);
  double operator()(const plane::Point& p) const;

private:
  struct Tip {
    plane::Point place;
    double radius;
  };
  const Mesh& mesh_;
  std::vector<Tip> tips_;
};

struct Ellipse {
  plane::Point centre, first, second;  ///< centre + cos(angle) first + sin(angle) second
};

/// Inserts a point of a curve as a corner of its polygon, in place of one that is close and need not stay.
void insert_vertex(plane::Polygon& corners, const plane::Point& p, const plane::Polygon& stays);

/// Where the sides of two polygons meet.
plane::Polygon intersections(const plane::Polygon& a, const plane::Polygon& b);

/// True if the spacing of the mesh is valid.
bool has_spacing(const Parameters& parameters, const Findings& findings);

/// Makes outlines, with curves as chords.
class ShapeBuilder {
public:
  explicit ShapeBuilder(const Parameters& parameters) : parameters_(parameters), spacing_(parameters) {}

  const MeshSpacing& spacing() const { return spacing_; }

  /// A closed curve. If it bounds the body, its chords end at the limits of condition regions on it, and at
  /// the outlines of regions.
  /// @param name of its faces
  plane::Polygon ellipse(const Ellipse& curve, const std::string& name) const;

  /// The outline of a figure; empty if a key is faulty, or for a polygon that intersects itself, which is
  /// reported.
  /// @param key of its table
  std::optional<plane::Polygon> outline(const plane::Hole& figure, const std::string& key,
                                        const std::string& name, Findings& findings) const;

private:
  const Parameters& parameters_;
  MeshSpacing spacing_;
};

/// The polygon with counter-clockwise orientation.
plane::Polygon counter_clockwise(plane::Polygon polygon);

inline plane::Point left_of(const plane::Point& vector) {
  return {-vector[1], vector[0]};
}

std::string show_place(const plane::Point& p);

/// Checks the keys of a figure that is a circle, an ellipse or a polygon.
void check_figure(const std::string& key, Findings& findings);

/// Reports too many chords at this key. @return true if there are none too many
bool check_chords(const std::string& key, const plane::Polygon& corners, Findings& findings);

/// Reports a corner too sharp for the quality of the mesh. @return true if it is not
/// @param name "the corner of the body at (0, 0)"
bool check_corner(const plane::Corner& corner, const std::string& name, const Parameters& parameters,
                  Findings& findings);

}  // namespace crackle::input
