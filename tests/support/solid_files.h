// SPDX-License-Identifier: GPL-3.0-or-later
// Closed surfaces and the files that hold them.
#pragma once

#include "common/index.h"
#include "common/random.h"
#include "common/vector.h"
#include "solid/facets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

namespace crackle::test {

using solid::Facets;
using solid::Polygon;

inline Vector random_direction(RandomStream& stream) {
  const double z = stream.uniform(-1, 1), turn = stream.uniform(0, 2 * std::numbers::pi),
               r = std::sqrt(1 - z * z);
  return {r * std::cos(turn), r * std::sin(turn), z};
}

/// The box between two corners, or a cavity of this shape.
inline void add_box(Facets& facets, const Vector& lower, const Vector& upper, bool is_cavity = false) {
  const std::size_t first = facets.points.size();
  for (unsigned i = 0; i < 8; ++i)
    facets.points.push_back({(i & 1u) != 0 ? upper[0] : lower[0], (i & 2u) != 0 ? upper[1] : lower[1],
                             (i & 4u) != 0 ? upper[2] : lower[2]});
  for (Polygon polygon : std::vector<Polygon>{
           {0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}) {
    for (std::size_t& corner : polygon) corner += first;
    if (is_cavity) std::ranges::reverse(polygon);
    facets.add(std::move(polygon));
  }
}

/// A convex body between random planes about the origin, at distances from 2 to 4.
inline Facets random_hull(RandomStream& stream, std::size_t n_planes) {
  std::vector<Vector> normal;
  std::vector<double> distance;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      Vector unit{};
      unit[axis] = side;
      normal.push_back(unit);
      distance.push_back(4);
    }
  for (std::size_t i = 0; i < n_planes; ++i) {
    normal.push_back(random_direction(stream));
    distance.push_back(stream.uniform(2, 4));
  }
  Facets facets;
  std::vector<Polygon> on(normal.size());
  for (std::size_t i = 0; i < normal.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      for (std::size_t k = 0; k < j; ++k) {
        const double volume = dot(normal[i], cross(normal[j], normal[k]));
        if (std::abs(volume) < 1e-9) continue;
        const Vector p =
            (distance[i] * cross(normal[j], normal[k]) + distance[j] * cross(normal[k], normal[i]) +
             distance[k] * cross(normal[i], normal[j])) /
            volume;
        bool is_corner = true;
        for (std::size_t m = 0; m < normal.size(); ++m)
          is_corner = is_corner && dot(normal[m], p) <= distance[m] + 1e-9;
        if (!is_corner) continue;
        for (const std::size_t m : {i, j, k}) on[m].push_back(facets.points.size());
        facets.points.push_back(p);
      }
  for (std::size_t m = 0; m < normal.size(); ++m) {
    if (on[m].size() < 3) continue;
    Vector centre{};
    for (const std::size_t corner : on[m])
      centre = centre + facets.points[corner] / static_cast<double>(on[m].size());
    const Vector along = facets.points[on[m][0]] - centre, across = cross(normal[m], along);
    std::ranges::sort(on[m], {}, [&](std::size_t corner) {
      const Vector to = facets.points[corner] - centre;
      return std::atan2(dot(to, across) / norm(across), dot(to, along) / norm(along));
    });
    facets.add(on[m]);
  }
  return facets;
}

/// Adds a shrunken copy of a body as a cavity in it.
inline void add_cavity(Facets& facets, double share) {
  const std::size_t n = facets.points.size(), n_polygons = facets.polygons.size();
  for (std::size_t i = 0; i < n; ++i) facets.points.push_back(share * facets.points[i]);
  for (std::size_t i = 0; i < n_polygons; ++i) {
    Polygon polygon = facets.polygons[i];
    for (std::size_t& corner : polygon) corner += n;
    std::ranges::reverse(polygon);
    facets.add(std::move(polygon));
  }
}

/// Replaces a facet by a dent.
inline void dent(Facets& facets, std::size_t facet, double share) {
  const Polygon polygon = facets.polygons[facet];
  Vector tip{};
  for (const std::size_t corner : polygon)
    tip = tip + (1 - share) * facets.points[corner] / static_cast<double>(polygon.size());
  facets.polygons.erase(facets.polygons.begin() + static_cast<std::ptrdiff_t>(facet));
  facets.group.erase(facets.group.begin() + static_cast<std::ptrdiff_t>(facet));
  facets.points.push_back(tip);
  for (std::size_t i = 0; i < polygon.size(); ++i)
    facets.add({polygon[i], polygon[(i + 1) % polygon.size()], facets.points.size() - 1});
}

inline std::string text_of(const Vector& p) {
  return fmt::format("{} {} {}", p[0], p[1], p[2]);
}

inline std::string corners_of(const Polygon& polygon, std::size_t first) {
  std::string text;
  for (const std::size_t corner : polygon) text += fmt::format(" {}", corner + first);
  return text;
}

inline std::string obj_of(const Facets& facets) {
  std::string text;
  for (const Vector& p : facets.points) text += "v " + text_of(p) + "\n";
  for (std::size_t i = 0; i < facets.polygons.size(); ++i) {
    if (facets.group[i] >= 0) text += "g " + facets.groups[index(facets.group[i])] + "\n";
    text += "f" + corners_of(facets.polygons[i], 1) + "\n";
  }
  return text;
}

inline std::string off_of(const Facets& facets) {
  std::string text = fmt::format("OFF\n{} {} 0\n", facets.points.size(), facets.polygons.size());
  for (const Vector& p : facets.points) text += text_of(p) + "\n";
  for (const Polygon& polygon : facets.polygons)
    text += fmt::format("{}{}\n", polygon.size(), corners_of(polygon, 0));
  return text;
}

/// Triangles only, by fans.
inline std::vector<std::array<Vector, 3>> triangles_of(const Facets& facets) {
  std::vector<std::array<Vector, 3>> triangles;
  for (const Polygon& polygon : facets.polygons)
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
      triangles.push_back(
          {facets.points[polygon[0]], facets.points[polygon[i]], facets.points[polygon[i + 1]]});
  return triangles;
}

inline std::string stl_of(const Facets& facets, const std::string& name = "body") {
  std::string text = "solid " + name + "\n";
  for (const auto& corners : triangles_of(facets)) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const Vector& p : corners) text += "vertex " + text_of(p) + "\n";
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid " + name + "\n";
}

template <class Number>
void append(std::string& bytes, Number number) {
  std::array<char, sizeof number> raw{};
  std::memcpy(raw.data(), &number, sizeof number);
  bytes.append(raw.begin(), raw.end());
}

inline std::string binary_stl_of(const Facets& facets) {
  std::string bytes(80, ' ');
  const auto triangles = triangles_of(facets);
  append(bytes, static_cast<std::uint32_t>(triangles.size()));
  for (const auto& corners : triangles) {
    for (int i = 0; i < 3; ++i) append(bytes, 0.0f);
    for (const Vector& p : corners)
      for (const double coordinate : p) append(bytes, static_cast<float>(coordinate));
    append(bytes, std::uint16_t{0});
  }
  return bytes;
}

inline std::string ply_of(const Facets& facets, bool is_binary) {
  std::string text = fmt::format(
      "ply\nformat {} 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double "
      "z\nelement face "
      "{}\nproperty list uchar int vertex_indices\nend_header\n",
      is_binary ? "binary_little_endian" : "ascii", facets.points.size(), facets.polygons.size());
  for (const Vector& p : facets.points) {
    if (!is_binary) text += text_of(p) + "\n";
    for (const double coordinate : p)
      if (is_binary) append(text, coordinate);
  }
  for (const Polygon& polygon : facets.polygons) {
    if (!is_binary) text += fmt::format("{}{}\n", polygon.size(), corners_of(polygon, 0));
    if (is_binary) append(text, static_cast<std::uint8_t>(polygon.size()));
    for (const std::size_t corner : polygon)
      if (is_binary) append(text, static_cast<std::int32_t>(corner));
  }
  return text;
}

/// Two tetrahedra that share a side, with the physical groups "base" and "tip".
inline std::string gmsh_of_two_tetrahedra(bool is_new) {
  const std::string names = "$PhysicalNames\n3\n2 1 \"base\"\n2 2 \"tip\"\n3 7 \"all\"\n$EndPhysicalNames\n";
  const std::array<const char*, 5> nodes{"0 0 0", "1 0 0", "0 1 0", "0 0 -1", "0.2 0.2 1"};
  std::string text;
  if (!is_new) {
    text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + names + "$Nodes\n5\n";
    for (std::size_t i = 0; i < nodes.size(); ++i) text += fmt::format("{} {}\n", 10 * (i + 1), nodes[i]);
    return text +
           "$EndNodes\n$Elements\n8\n1 15 2 0 1 10\n2 2 2 1 4 10 20 40\n3 2 2 1 4 20 30 40\n4 2 2 1 4 10 40 "
           "30\n"
           "5 2 2 2 5 10 20 50\n6 4 2 7 1 10 20 30 50\n7 4 2 7 1 10 20 30 40\n8 2 2 2 5 20 30 "
           "50\n$EndElements\n";
  }
  text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n" + names +
         "$Entities\n0 0 2 1\n4 0 0 0 1 1 1 1 1 0\n5 0 0 0 1 1 1 1 2 0\n1 0 0 0 1 1 1 1 7 0\n$EndEntities\n"
         "$Nodes\n1 5 10 50\n3 1 0 5\n10\n20\n30\n40\n50\n";
  for (const char* const node : nodes) text += std::string(node) + "\n";
  return text +
         "$EndNodes\n$Elements\n3 7 1 7\n2 4 2 3\n1 10 20 40\n2 20 30 40\n3 10 40 30\n2 5 2 2\n4 10 20 50\n"
         "7 20 30 50\n3 1 4 2\n5 10 20 30 50\n6 10 20 30 40\n$EndElements\n";
}

/// The same without names.
inline std::string vtk_of_two_tetrahedra(bool is_new) {
  const std::string head = fmt::format(
      "# vtk DataFile Version {}\ntwo cells\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n0 0 0 1 0 0 "
      "0 1 0\n"
      "0 0 -1 0.2 0.2 1\n",
      is_new ? "5.1" : "3.0");
  const std::string cells =
      is_new ? "CELLS 3 8\nOFFSETS vtktypeint64\n0 4 8\nCONNECTIVITY vtktypeint64\n0 1 2 4 0 1 2 3\n"
             : "CELLS 2 10\n4 0 1 2 4\n4 0 1 2 3\n";
  return head + cells + "CELL_TYPES 2\n10\n10\n";
}

}  // namespace crackle::test
