// SPDX-License-Identifier: GPL-3.0-or-later
// A body made from a few given facets.
#pragma once

#include "common/index.h"
#include "geometry/body.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace crackle::test {

struct GivenFacet {
  std::string name;
  std::vector<int> corners;  ///< in order, counter-clockwise seen from outside
};

/// The polyhedron of these facets: its areas and its volume follow from its corners.
inline geometry::Complex polyhedron(std::vector<geometry::Point> corners,
                                    const std::vector<GivenFacet>& facets) {
  using geometry::Point;
  geometry::Complex complex;
  complex.bounds = geometry::nowhere;
  for (const Point& p : corners) complex.bounds.include(p);
  std::set<std::pair<int, int>> edges;
  for (const GivenFacet& given : facets) {
    const auto corner = [&](std::size_t i) {
      return corners[index(given.corners[i % given.corners.size()])];
    };
    const std::size_t n = given.corners.size();
    Vector twice{};  // vector area
    for (std::size_t i = 1; i + 1 < n; ++i)
      twice = twice + cross(corner(i) - corner(0), corner(i + 1) - corner(0));
    const Vector outward = twice / norm(twice);
    const Vector along = (corner(1) - corner(0)) / norm(corner(1) - corner(0));
    geometry::Patch patch{{}, corner(0), {along, cross(outward, along), outward}};
    geometry::Face face{{given.name}, norm(twice) / 2, outward, patch};
    geometry::Box own{{}, {}};
    for (std::size_t i = 0; i < n; ++i) {
      const Point from = patch.own(corner(i)), to = patch.own(corner(i + 1));
      face.rim.push_back({{{from[0], from[1]}, {to[0], to[1]}}});
      own.include({from[0], from[1], 0});
      edges.insert(std::minmax(given.corners[i], given.corners[(i + 1) % n]));
    }
    face.patch.domain = own;
    complex.volume += dot(corner(0), twice) / 6;
    complex.faces.push_back(std::move(face));
  }
  for (const auto& [from, to] : edges) complex.edges.emplace_back(corners[index(from)], corners[index(to)]);
  complex.corners = std::move(corners);
  return complex;
}

}  // namespace crackle::test
