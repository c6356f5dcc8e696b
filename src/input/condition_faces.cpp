// SPDX-License-Identifier: GPL-3.0-or-later
#include "condition_faces.h"

#include <fmt/format.h>

#include <algorithm>

namespace crackle::input {

std::string boundary_key(std::size_t i) {
  return fmt::format("boundary[{}]", i);
}

std::optional<plane::Face> box_face(const Boundary& condition, const plane::Specimen& specimen) {
  if (!is_box(specimen)) return {};
  for (std::size_t i = 0; i < plane::box_edges.size(); ++i)
    if (condition.on == fmt::format("edge-{}", i)) return plane::box_edges[i];
  const auto found = std::ranges::find(plane::face_names, condition.on);
  if (found == plane::face_names.end()) return {};
  return static_cast<plane::Face>(found - plane::face_names.begin());
}

std::vector<Wall> walls_of(const plane::Shape& shape) {
  std::vector<Wall> walls;
  for (std::size_t l = 0; l < shape.loops.size(); ++l) {
    const plane::Loop& loop = shape.loops[l];
    for (std::size_t i = 0; i < loop.size(); ++i)
      walls.push_back({loop.from(i), loop.to(i), plane::names_of_side(shape, l, i)});
  }
  return walls;
}

std::optional<std::pair<double, double>> share_in(const Wall& wall, const plane::Region& region) {
  double first = 0;
  double last = 1;
  for (std::size_t i = 0; i < 2; ++i) {
    const double slack = 1e-12;
    const auto [lower, upper] = region[i + 1];
    const double length = wall.to[i] - wall.from[i];
    if (length == 0) {
      if (wall.from[i] < lower - slack || wall.from[i] > upper + slack) return {};
      continue;
    }
    const auto [enters, leaves] =
        std::minmax({(lower - slack - wall.from[i]) / length, (upper + slack - wall.from[i]) / length});
    first = std::max(first, enters);
    last = std::min(last, leaves);
  }
  if (!(first < last)) return {};
  return std::pair{first, last};
}

plane::Region part_of_face(const Boundary& condition, plane::Face face, const Vector& size) {
  plane::Region part;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    part[axis] = {std::max(condition.region[axis].first, 0.0),
                  std::min(condition.region[axis].second, size[axis])};
  }
  const auto normal = static_cast<std::size_t>(axis_of(face));
  const double position = is_upper(face) ? size[normal] : 0;
  part[normal] = {position, position};
  return part;
}

bool has_name(const Wall& wall, const std::string& name) {
  return std::ranges::find(wall.names, name) != wall.names.end();
}

}  // namespace crackle::input
