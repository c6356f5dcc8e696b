// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/tool_shape.h"

#include "common/real.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace crackle::dynamics {

namespace {

/// The surface of a shape with rounded edges: its flat sides are moved in by the rounding, and the surface
/// lies that far from what is left.
/// @param beyond distance beyond each pair of sides moved in, negative inside [m]
/// @param outward unit vector out of each pair, on the side of the point
template <std::size_t n>
ToolSurface rounded(const std::array<double, n>& beyond, const std::array<Vector, n>& outward,
                    double rounding) {
  const auto nearest = static_cast<std::size_t>(std::ranges::max_element(beyond) - beyond.begin());
  if (beyond[nearest] <= 0) return {beyond[nearest] - rounding, outward[nearest]};
  Vector from{};
  for (std::size_t i = 0; i < n; ++i) from = from + std::max(beyond[i], 0.0) * outward[i];
  const double length = norm(from);
  return {length - rounding, from / length};
}

ToolSurface round_surface(const Vector& from, double radius) {
  const double length = norm(from);
  if (length == 0) return {-radius, {1, 0, 0}};
  return {length - radius, from / length};
}

}  // namespace

ToolSurface surface_from(const input::Tool& tool, const Vector& p) {
  switch (tool.shape) {
    case input::ToolShape::plane: {
      const Vector normal = tool.axis / norm(tool.axis);
      return {dot(p, normal), normal};
    }
    case input::ToolShape::sphere:
      return round_surface(p, tool.radius);
    case input::ToolShape::cylinder: {
      const Vector axis = tool.axis / norm(tool.axis);
      const double along = dot(p, axis);
      const ToolSurface round = round_surface(p - along * axis, tool.radius);
      if (tool.size.empty()) return round;
      return rounded<2>(
          {round.distance + tool.rounding, std::abs(along) - 0.5 * tool.size[0] + tool.rounding},
          {round.normal, (along < 0 ? -1.0 : 1.0) * axis}, tool.rounding);
    }
    case input::ToolShape::box: {
      std::array<double, 3> beyond{};
      std::array<Vector, 3> outward{};
      for (std::size_t i = 0; i < 3; ++i) {
        beyond[i] = std::abs(p[i]) - 0.5 * tool.size[i] + tool.rounding;
        outward[i][i] = p[i] < 0 ? -1 : 1;
      }
      return rounded<3>(beyond, outward, tool.rounding);
    }
  }
  return {};
}

double largest_section(const input::Tool& tool) {
  const double disk = std::numbers::pi * tool.radius * tool.radius;
  switch (tool.shape) {
    case input::ToolShape::plane:
      return infinity;
    case input::ToolShape::sphere:
      return disk;
    case input::ToolShape::cylinder:
      return tool.size.empty() ? infinity : std::max(disk, 2 * tool.radius * tool.size[0]);
    case input::ToolShape::box:
      return tool.size[0] * tool.size[1] * tool.size[2] / std::ranges::min(tool.size);
  }
  return infinity;
}

}  // namespace crackle::dynamics
