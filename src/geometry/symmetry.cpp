// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/geometry/symmetry.h"

#include "crackle/common/failure.h"
#include "crackle/geometry/mesh_regions.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace crackle::geometry {

namespace {

constexpr double tolerance = 1e-12;  ///< of coordinates, relative to the body's largest size

}  // namespace

std::vector<Symmetry> symmetries(const Body& body, const input::Mesh& mesh) {
  const Point size = body.size();
  const double near = tolerance * *std::ranges::max_element(size);
  // Symmetries are isometries, so a box whose corners map onto corners of another box maps onto that box.
  const auto maps = [&](const Symmetry& symmetry, const input::MeshRegion& from,
                        const input::MeshRegion& to) {
    const auto corners = corners_of(box_of(to, body.bounds()));
    return from.spacing == to.spacing &&
           std::ranges::all_of(corners_of(box_of(from, body.bounds())), [&](const Point& p) {
             const Point image = symmetry.image(p);
             return std::ranges::any_of(corners, [&](const Point& corner) {
               const Point gap = image - corner;
               return std::ranges::all_of(gap, [&](double each) { return std::abs(each) <= near; });
             });
           });
  };
  std::vector<Symmetry> result = body.symmetries();
  std::erase_if(result, [&](const Symmetry& symmetry) {
    return !std::ranges::all_of(mesh.regions, [&](const input::MeshRegion& from) {
      return std::ranges::any_of(mesh.regions, [&](const auto& to) { return maps(symmetry, from, to); });
    });
  });
  return result;
}

Symmetry symmetry_of(const Body& body, std::uint8_t code) {
  for (Symmetry& symmetry : body.symmetries())
    if (symmetry.code == code) return std::move(symmetry);
  fail<std::invalid_argument>("the body has no symmetry {}", code);
}

}  // namespace crackle::geometry
