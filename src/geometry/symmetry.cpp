// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/geometry/symmetry.h"

#include "crackle/geometry/mesh_regions.h"

#include <algorithm>
#include <cmath>

namespace crackle::geometry {

namespace {

constexpr double tolerance = 1e-12;  ///< of coordinates, in the body's largest size

double nearness(const Body& body) {
  return tolerance * *std::max_element(body.size().begin(), body.size().end());
}

/// The coordinate's image under reflection in the middle of the axis; on a plane of the body if it comes
/// near.
double image(const Body& body, std::size_t axis, double coordinate) {
  const double reflected = body.size()[axis] - coordinate;
  const double near = nearness(body);
  for (const Surface& surface : body.surfaces())
    if (static_cast<std::size_t>(surface.axis) == axis && std::abs(surface.position - reflected) <= near)
      return surface.position;
  return reflected;
}

Box image(const Body& body, std::uint8_t axes, const Box& box) {
  Box result = box;
  for (std::size_t i = 0; i < 3; ++i)
    if ((axes >> i) & 1u) {
      result.lower[i] = image(body, i, box.upper[i]);
      result.upper[i] = image(body, i, box.lower[i]);
    }
  return result;
}

}  // namespace

Point reflected(const Body& body, std::uint8_t axes, const Point& p) {
  Point q = p;
  for (std::size_t i = 0; i < 3; ++i)
    if ((axes >> i) & 1u) q[i] = image(body, i, p[i]);
  return q;
}

std::vector<std::uint8_t> symmetries(const Body& body) {
  const auto is_a_slot = [&](const Box& box) {
    for (int i = 0; i < body.n_notches(); ++i)
      if (body.slot(i).lower == box.lower && body.slot(i).upper == box.upper) return true;
    return false;
  };
  std::vector<std::uint8_t> result;
  for (std::uint8_t axes = 0; axes < 8; ++axes) {
    bool fits = true;
    for (int i = 0; i < body.n_notches(); ++i) fits = fits && is_a_slot(image(body, axes, body.slot(i)));
    if (fits) result.push_back(axes);
  }
  return result;
}

std::vector<std::uint8_t> symmetries(const Body& body, const input::Mesh& mesh) {
  const double near = nearness(body);
  const auto is_a_region = [&](const Box& box, double spacing) {
    return std::ranges::any_of(mesh.regions, [&](const input::MeshRegion& region) {
      const Box other = box_of(region, body.size());
      bool same = region.spacing == spacing;
      for (std::size_t i = 0; i < 3; ++i)
        same = same && std::abs(other.lower[i] - box.lower[i]) <= near &&
               std::abs(other.upper[i] - box.upper[i]) <= near;
      return same;
    });
  };
  std::vector<std::uint8_t> result = symmetries(body);
  std::erase_if(result, [&](std::uint8_t axes) {
    return !std::ranges::all_of(mesh.regions, [&](const input::MeshRegion& region) {
      return is_a_region(image(body, axes, box_of(region, body.size())), region.spacing);
    });
  });
  return result;
}

}  // namespace crackle::geometry
