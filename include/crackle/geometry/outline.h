// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace crackle::geometry {

/// The body as its projection on the y-z plane shows it, for drawing. Lengths in m.
struct Outline {
  std::vector<double> size;         ///< of the box along x, y and z
  std::vector<double> points;       ///< y, z of the polygons' corners, one polygon after the other
  std::vector<std::int32_t> first;  ///< corner of each polygon, and one past the last of all
  std::vector<double> tips;         ///< y, z in the middle of each notch's tip
  std::vector<double> slots;        ///< of each notch its least and greatest y, and its least and greatest z
  std::vector<std::int32_t> axis;   ///< of each notch: 1 y, 2 z, along which its crack advances
  std::vector<std::int32_t>
      direction;  ///< of each notch: 1 or -1, in which its crack advances along the axis
};

/// The polygons are not closed by a copy of their first corner. The first one, counter-clockwise from the
/// origin, is the box with its slots.
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
  visit("notch_tip", Shape{n, 2}, outline.tips, "m", "y, z in the middle of the tip");
  visit("notch_slot", Shape{n, 2, 2}, outline.slots, "m", "least and greatest y and z of the slot");
  visit("notch_axis", Shape{n}, outline.axis, "", "axis along which the crack advances: 1 y, 2 z");
  visit("notch_direction", Shape{n}, outline.direction, "",
        "1 or -1: in which the crack advances along the axis");
}

}  // namespace crackle::geometry
