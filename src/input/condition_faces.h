// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/parameters.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

/// The parts of a body's surface on which boundary conditions act.
namespace crackle::input {

/// "boundary[1]"
std::string boundary_key(std::size_t i);

inline bool prescribes_motion(const Boundary& condition) {
  return prescribes_motion(condition.kind);
}

/// The box face on which a condition acts; empty if its name is that of something else.
std::optional<plane::Face> box_face(const Boundary& condition, const plane::Specimen& specimen);

/// The part of its face on which a condition acts; along the face's normal both limits are the face's
/// position.
plane::Region part_of_face(const Boundary& condition, plane::Face face, const Vector& size);

/// A wall through the thickness as a segment in the plane of the plate.
struct Wall {
  plane::Point from, to;
  std::vector<std::string> names;
};

std::vector<Wall> walls_of(const plane::Shape& shape);
bool has_name(const Wall& wall, const std::string& name);

/// The part of a wall inside a region, as an interval of its length; empty if there is none.
std::optional<std::pair<double, double>> share_in(const Wall& wall, const plane::Region& region);

}  // namespace crackle::input
