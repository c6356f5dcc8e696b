// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/geometry/face_neighbours.h"

#include "crackle/common/index.h"

#include <algorithm>

namespace crackle::geometry {

std::vector<std::array<std::int32_t, 4>> face_neighbours(std::span<const Tetrahedron> tetrahedra) {
  struct Face {
    Triangle nodes;
    std::int32_t place;  // 4 x tetrahedron + opposite corner
  };
  std::vector<Face> faces;
  faces.reserve(4 * tetrahedra.size());
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      Face face{{}, static_cast<std::int32_t>(4 * t + opposite)};
      for (std::size_t k = 0, n = 0; k < 4; ++k)
        if (k != opposite) face.nodes[n++] = tetrahedra[t][k];
      std::ranges::sort(face.nodes);
      faces.push_back(face);
    }
  }
  std::ranges::sort(faces, {}, &Face::nodes);
  std::vector<std::array<std::int32_t, 4>> neighbours(tetrahedra.size(), {-1, -1, -1, -1});
  for (std::size_t i = 1; i < faces.size(); ++i) {
    if (faces[i - 1].nodes != faces[i].nodes) continue;
    const std::int32_t a = faces[i - 1].place, b = faces[i].place;
    neighbours[index(a / 4)][index(a % 4)] = b / 4;
    neighbours[index(b / 4)][index(b % 4)] = a / 4;
  }
  return neighbours;
}

}  // namespace crackle::geometry
