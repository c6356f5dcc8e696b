// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/vector.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

/// Closed surfaces from files.
namespace crackle::solid {

using Polygon = std::vector<std::size_t>;  ///< numbers of points, in order

/// The facets of a surface, as a file gives them.
struct Facets {
  std::vector<Vector> points;  ///< in the file's unit
  std::vector<Polygon> polygons;
  std::vector<int> group;           ///< of each polygon, or -1
  std::vector<std::string> groups;  ///< their names

  void add(Polygon polygon, int of_group = -1);
  /// The group with this name, which is made if there is none; -1 without a name.
  /// @param text which need not be printable
  int group_named(const std::string& text);
};

/// @param extension one of those of solid.h
/// @throws std::runtime_error saying what is wrong with the content
Facets read_facets(const std::string& content, const std::string& extension);

// The readers of volume meshes. (CGAL's readers of surfaces stop the program at damaged files, and leave
// groups out.)
Facets read_gmsh(const std::string& content);
Facets read_vtk(const std::string& content);

}  // namespace crackle::solid
