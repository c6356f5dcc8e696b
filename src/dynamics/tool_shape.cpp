// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/tool_shape.h"

#include "common/real.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

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

/// Volume of a body, and its second moment along an axis from its middle [m^3, m^5]. Its section is
/// a + b s + pi s^2: s is the rounding where the body is flat, and falls as a quarter of a circle does
/// beyond.
/// @param flat half the length without roundings
std::array<double, 2> moments_along(double flat, double rounding, double a, double b) {
  constexpr double pi = std::numbers::pi;
  const double h = flat, r = rounding, section = a + b * r + pi * r * r, end = h + r;
  return {2 * (h * section + a * r + b * pi * r * r / 4 + pi * 2 * r * r * r / 3),
          2 * (h * h * h / 3 * section + a * (end * end * end - h * h * h) / 3 +
               b * (h * h * pi * r * r / 4 + h * 2 * r * r * r / 3 + pi * r * r * r * r / 16) +
               pi * (h * h * 2 * r * r * r / 3 + h * r * r * r * r / 2 + 2 * r * r * r * r * r / 15))};
}

Eigen::Vector3d direction_of(const input::Tool& tool) {
  return Eigen::Vector3d(tool.axis.data()).normalized();
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

Vector farthest_point(const input::Tool& tool) {
  if (tool.shape == input::ToolShape::box)
    return {0.5 * tool.size[0], 0.5 * tool.size[1], 0.5 * tool.size[2]};
  if (tool.shape == input::ToolShape::cylinder && !tool.size.empty()) {
    const Eigen::Vector3d axis = direction_of(tool);
    const Eigen::Vector3d end = 0.5 * tool.size[0] * axis + tool.radius * axis.unitOrthogonal();
    return {end[0], end[1], end[2]};
  }
  return {tool.radius, 0, 0};
}

Eigen::Matrix3d moment_of_inertia(const input::Tool& tool) {
  const double r = tool.rounding;
  switch (tool.shape) {
    case input::ToolShape::plane:
      break;
    case input::ToolShape::sphere:
      return 0.4 * tool.mass * tool.radius * tool.radius * Eigen::Matrix3d::Identity();
    case input::ToolShape::cylinder: {
      // Its section has the radius c + s.
      constexpr double pi = std::numbers::pi;
      const double c = tool.radius - r, flat = 0.5 * tool.size[0] - r;
      const auto [volume, along] = moments_along(flat, r, pi * c * c, 2 * pi * c);
      const double s = tool.radius * tool.radius, cc = c * c, rr = r * r;
      const double across = pi * (flat * s * s + r * cc * cc + pi * rr * cc * c + 4 * r * rr * cc +
                                  3 * pi / 4 * rr * rr * c + 8.0 / 15 * rr * rr * r);
      const double axial = tool.mass * across / volume;
      const double transverse = tool.mass * (0.5 * across + along) / volume;
      const Eigen::Vector3d axis = direction_of(tool);
      return transverse * Eigen::Matrix3d::Identity() + (axial - transverse) * axis * axis.transpose();
    }
    case input::ToolShape::box: {
      Eigen::Vector3d square;  // mean square of each coordinate
      for (std::size_t i = 0; i < 3; ++i) {
        const double b = tool.size[(i + 1) % 3] - 2 * r, c = tool.size[(i + 2) % 3] - 2 * r;
        const auto [volume, along] = moments_along(0.5 * tool.size[i] - r, r, b * c, 2 * (b + c));
        square[static_cast<Eigen::Index>(i)] = along / volume;
      }
      return tool.mass * (square.sum() * Eigen::Vector3d::Ones() - square).asDiagonal().toDenseMatrix();
    }
  }
  return Eigen::Matrix3d::Constant(infinity);
}

double least_mass(const input::Tool& tool) {
  if (!tool.turns()) return tool.mass;
  const Vector point = farthest_point(tool);
  Eigen::Matrix3d arm;
  arm << 0, -point[2], point[1], point[2], 0, -point[0], -point[1], point[0], 0;
  const Eigen::Matrix3d turning = arm * moment_of_inertia(tool).inverse() * arm.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(turning, Eigen::EigenvaluesOnly);
  return 1 / (1 / tool.mass + solver.eigenvalues().maxCoeff());
}

}  // namespace crackle::dynamics
