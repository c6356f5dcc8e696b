// SPDX-License-Identifier: GPL-3.0-or-later
#include "face_points.h"

#include "crackle/common/index.h"
#include "crackle/common/vector.h"

#include <algorithm>
#include <array>
#include <optional>

namespace crackle::geometry {

std::vector<Point> missing_face_points(const Body& body, std::span<const Point> points,
                                       std::span<const double> spacing, std::span<const Tetrahedron> crossing,
                                       double margin) {
  std::vector<Point> added;
  for (const Tetrahedron& t : crossing) {
    const std::array<Point, 4> corners{points[index(t[0])], points[index(t[1])], points[index(t[2])],
                                       points[index(t[3])]};
    if (body.classify(corners) != Containment::straddling) continue;
    for (std::size_t face = 0; face < body.n_meshed_faces(); ++face)
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < i; ++j) {
          const double local = (spacing[index(t[i])] + spacing[index(t[j])]) / 2;
          const std::optional<Point> p =
              body.passage(static_cast<FaceId>(face), corners[i], corners[j], margin * local);
          if (p && body.movable(*p) != 0 && std::none_of(added.begin(), added.end(), [&](const Point& other) {
                return norm(*p - other) < 0.5 * local;
              }))
            added.push_back(*p);
        }
  }
  return added;
}

}  // namespace crackle::geometry
