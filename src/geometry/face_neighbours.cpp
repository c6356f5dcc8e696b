// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/face_neighbours.h"

#include "common/index.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace crackle::geometry {

namespace {

/// The nodes of the face opposite to a corner, ascending.
/// @param place 4 x tetrahedron + corner
Triangle face_at(std::span<const Tetrahedron> tetrahedra, std::int32_t place) {
  Triangle face{};
  for (std::size_t k = 0, n = 0; k < 4; ++k)
    if (k != index(place % 4)) face[n++] = tetrahedra[index(place / 4)][k];
  std::ranges::sort(face);
  return face;
}

}  // namespace

std::vector<std::array<std::int32_t, 4>> face_neighbours(std::span<const Tetrahedron> tetrahedra) {
  // Faces in buckets by their smallest node, then sorted within these.
  const auto n_places = static_cast<std::int32_t>(4 * tetrahedra.size());
  std::vector<std::int32_t> begin;
  for (std::int32_t place = 0; place < n_places; ++place) {
    const std::size_t bucket = index(face_at(tetrahedra, place)[0]);
    if (bucket + 2 > begin.size()) begin.resize(bucket + 2, 0);
    ++begin[bucket + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::int32_t> places(index(n_places));
  std::vector<std::int32_t> next = begin;
  for (std::int32_t place = 0; place < n_places; ++place)
    places[index(next[index(face_at(tetrahedra, place)[0])]++)] = place;

  std::vector<std::array<std::int32_t, 4>> neighbours(tetrahedra.size(), {-1, -1, -1, -1});
  std::vector<std::pair<Triangle, std::int32_t>> faces;
  for (std::size_t bucket = 0; bucket + 1 < begin.size(); ++bucket) {
    faces.clear();
    for (std::int32_t i = begin[bucket]; i < begin[bucket + 1]; ++i)
      faces.emplace_back(face_at(tetrahedra, places[index(i)]), places[index(i)]);
    std::ranges::sort(faces);
    for (std::size_t i = 1; i < faces.size(); ++i) {
      if (faces[i - 1].first != faces[i].first) continue;
      const std::int32_t a = faces[i - 1].second, b = faces[i].second;
      neighbours[index(a / 4)][index(a % 4)] = b / 4;
      neighbours[index(b / 4)][index(b % 4)] = a / 4;
    }
  }
  return neighbours;
}

}  // namespace crackle::geometry
