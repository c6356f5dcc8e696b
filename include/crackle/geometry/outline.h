// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace crackle::geometry {

/// The body as its projection on the y-z plane shows it, for drawing. Lengths in m.
struct Outline {
  std::vector<double> size;         ///< of the box along x, y and z
  std::vector<double> points;       ///< y, z of the polygons' corners, one polygon after the other
  std::vector<std::int32_t> first;  ///< corner of each polygon, and one past the last of all
  std::vector<std::string> names;   ///< of each crack start: notch-0, hole-0, free surface
  std::vector<double> tips;         ///< y, z of each crack start's tip; crack starts are notches in the files
  std::vector<double> slots;        ///< of each start's faces least and greatest y, least and greatest z
  std::vector<std::int32_t> axis;  ///< of each start: 1 y, 2 z, along which its crack advances most; 0 in any
  std::vector<std::int32_t>
      direction;  ///< of each start: 1 or -1, in which its crack advances along the axis; 0 in any
};

/// What the body says of itself (Body::outline, Body::crack_starts), as lists.
Outline outline_of(const Body& body);

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
  visit("notch_slot", Shape{n, 2, 2}, outline.slots, "m", "least and greatest y and z of the slot");
  visit("notch_axis", Shape{n}, outline.axis, "", "axis along which the crack advances: 1 y, 2 z");
  visit("notch_direction", Shape{n}, outline.direction, "",
        "1 or -1: in which the crack advances along the axis");
}

}  // namespace crackle::geometry
