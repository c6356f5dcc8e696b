// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace crackle::geometry {

/// The projection of a plate on the y-z plane, or the edges of a solid, for drawing. Lengths in m.
struct Outline {
  std::vector<double> size;         ///< of the bounding box along x, y and z
  std::vector<double> points;       ///< y, z of the polygons' corners, one polygon after the other
  std::vector<std::int32_t> first;  ///< index of each polygon's first corner, and one past the last of all
  std::vector<std::string> names;   ///< of each crack start: notch-0, hole-0, free surface
  std::vector<double>
      tips;  ///< y, z of each crack start's tip; the members of crack starts are called notch_...
  std::vector<double> slots;  ///< min and max y, min and max z of each start's faces
  std::vector<std::int32_t>
      axis;  ///< per start: axis along which its crack mainly advances, 1 for y, 2 for z; 0 if any
  std::vector<std::int32_t> direction;  ///< per start: 1 or -1, direction of advance along the axis; 0 if any
  std::vector<double> pre_cracks;  ///< y, z of the corners of the pre-cracks' borders, one after the other
  std::vector<std::int32_t> first_of_pre_crack;  ///< as `first`; empty without any
  std::vector<double> edges;  ///< of a body that is no plate: x, y, z of both ends of each edge
};

/// Body::outline and Body::crack_starts as lists.
/// @param flaws of a sample, which count as pre-cracks
Outline outline_of(const Body& body, std::span<const plane::PreCrack> flaws = {});

/// Calls visit(name, shape, values, units, meaning) for every list of an outline: the members of /specimen in
/// the result files.
template <class Visit>
void for_each_member(const Outline& outline, Visit&& visit) {
  using Shape = std::vector<std::size_t>;
  const std::size_t n = outline.axis.size();
  visit("size", Shape{3}, outline.size, "m", "of the box along x, y and z");
  visit("outline", Shape{outline.points.size() / 2, 2}, outline.points, "m", "y, z of the polygons' corners");
  visit("outline_first", Shape{outline.first.size()}, outline.first, "",
        "first corner of each polygon, and one past the last of all");
  visit("notch_name", Shape{n}, outline.names, "",
        "crack starts: notches and holes as the input numbers them, and the free surface");
  visit("notch_tip", Shape{n, 2}, outline.tips, "m", "y, z in the middle of the tip");
  visit("notch_slot", Shape{n, 2, 2}, outline.slots, "m", "smallest and largest y and z of the slot");
  visit("notch_axis", Shape{n}, outline.axis, "", "axis along which the crack advances: 1 y, 2 z");
  visit("notch_direction", Shape{n}, outline.direction, "",
        "1 or -1: direction of crack advance along the axis");
  if (!outline.edges.empty())
    visit("edge", Shape{outline.edges.size() / 6, 2, 3}, outline.edges, "m",
          "x, y, z of both ends of each edge of a solid");
  if (outline.pre_cracks.empty()) return;
  visit("pre_crack", Shape{outline.pre_cracks.size() / 2, 2}, outline.pre_cracks, "m",
        "y, z of the corners of pre-cracks");
  visit("pre_crack_first", Shape{outline.first_of_pre_crack.size()}, outline.first_of_pre_crack, "",
        "first corner of each, and one past the last of all");
}

}  // namespace crackle::geometry
