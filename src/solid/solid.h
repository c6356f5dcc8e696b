// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/vector.h"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

/// Bodies from files of closed surfaces.
namespace crackle::solid {

/// Of the names of files that can be read.
inline constexpr std::array extensions{".stl", ".obj", ".off", ".ply", ".msh", ".vtk"};
/// What these are, for messages.
inline constexpr const char* accepted_files =
    "the name of a file with a closed surface (.stl, .obj, .off, .ply), or a mesh of Gmsh (.msh) or VTK "
    "(.vtk) "
    "in ASCII, relative to the input file";

/// A plane polygon of the surface, perhaps with holes.
struct Face {
  std::vector<std::string> names;       ///< the first one is for messages
  double area = 0;                      ///< [m^2]
  Vector outward{};                     ///< unit normal
  int axis = -1;                        ///< to which it is normal, exactly, if any
  std::vector<std::array<int, 2>> rim;  ///< numbers of points; the face is to its left, seen from outside
};

/// A body in one piece, perhaps with cavities, that consists of plane faces. Facets of the file in one plane,
/// up to the rounding of its coordinates, are one face.
struct Solid {
  std::string content;                              ///< of the file
  std::string digest;                               ///< of the content
  std::string extension;                            ///< of the file's name, in lower case
  std::string unit;                                 ///< of the file's coordinates
  double metres = 1;                                ///< size of the unit [m]
  std::vector<Vector> points;                       ///< [m]
  std::vector<std::array<std::int32_t, 3>> facets;  ///< counter-clockwise seen from outside
  std::vector<int> face_of;                         ///< of each facet
  std::vector<Face> faces;
  std::vector<std::array<int, 2>> edges;  ///< between faces; several in one line are one
  std::array<std::pair<double, double>, 3> bounds{};
  double volume = 0;  ///< [m^3]
  double moved = 0;   ///< largest distance of a point from its place in the file [m]
};

/// The digest of its file; empty without a solid.
inline std::string digest_of(const std::shared_ptr<const Solid>& solid) {
  return solid ? solid->digest : std::string();
}

/// All faces with one name.
struct NamedFace {
  std::string name;
  std::size_t n_planes = 0;
  double area = 0;   ///< [m^2]
  Vector centre{};   ///< of its area [m]
  Vector outward{};  ///< mean over the area; zero if it is closed
};

/// In the order of the file; names of planes at an end of the body come after the others.
std::vector<NamedFace> named_faces(const Solid& solid);

/// Where the body is sharp.
struct Sharpness {
  double angle;  ///< of the material, at an edge or in a face at a corner [rad]
  Vector place;  ///< [m]
  bool is_edge;
};
Sharpness sharpest(const Solid& solid);

/// True in the body and within this distance of its surface [m].
bool contains(const Solid& solid, const Vector& p, double slack);

/// The area of the faces with both names inside a box [m^2].
double area_in(const Solid& solid, const std::string& name, const std::string& other,
               const std::array<std::pair<double, double>, 3>& box);

/// Reads a closed surface and checks it. Facets are oriented and points that coincide are merged.
/// @param content of the file
/// @param unit of its coordinates, for messages, and its size [m]
/// @throws std::runtime_error saying what is wrong, and where
Solid read_solid(std::string content, const std::string& extension, const std::string& unit, double metres);

}  // namespace crackle::solid
