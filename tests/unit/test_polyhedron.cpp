// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies that are no plates, from a few given facets: the mesher asks nothing that only a plate can answer.
#include "geometry/mother_points.h"
#include "geometry/quality.h"
#include "geometry/realization.h"

#include "support/geometry_bodies.h"
#include "support/polyhedron.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numbers>

namespace crackle::geometry {
namespace CRACKLE_TEST_FILE {

using test::polyhedron;
using testing::mm;

/// A tetrahedron of which no face is normal to an axis.
Complex tetrahedron() {
  return polyhedron(
      {{1 * mm, 0.5 * mm, 0}, {9 * mm, 1 * mm, 2 * mm}, {3 * mm, 8 * mm, 1 * mm}, {4 * mm, 3 * mm, 7 * mm}},
      {{"below", {0, 2, 1}}, {"front", {0, 1, 3}}, {"right", {1, 2, 3}}, {"left", {0, 3, 2}}});
}

/// A wedge of 35 degrees, turned in space.
Complex wedge() {
  const double angle = 35 * std::numbers::pi / 180;
  const auto turned = [](double x, double y, double z) {
    const double c = std::cos(0.3), s = std::sin(0.3);
    const double u = c * x - s * y, v = s * x + c * y;
    return Point{u * mm, (c * v - s * z) * mm, (s * v + c * z) * mm};
  };
  std::vector<Point> corners;
  for (const double z : {0.0, 5.0}) {
    corners.push_back(turned(0, 0, z));
    corners.push_back(turned(8, 0, z));
    corners.push_back(turned(8 * std::cos(angle), 8 * std::sin(angle), z));
  }
  return polyhedron(corners, {{"lower-end", {0, 2, 1}},
                              {"upper-end", {3, 4, 5}},
                              {"floor", {0, 1, 4, 3}},
                              {"back", {1, 2, 5, 4}},
                              {"roof", {0, 3, 5, 2}}});
}

/// A block with a step: faces that are not convex, an edge that is re-entrant, and oblique ones.
Complex step() {
  const std::vector<std::array<double, 2>> outline{{0, 0}, {8, 0}, {8, 3}, {4, 3.5}, {3, 7}, {0, 7}};
  std::vector<Point> corners;
  for (const double z : {0.0, 4.0})
    for (const auto& [x, y] : outline) corners.push_back({x * mm, y * mm + 0.3 * z * mm, z * mm});
  const int n = static_cast<int>(outline.size());
  std::vector<test::GivenFacet> facets{{"lower", {}}, {"upper", {}}};
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    facets[0].corners.insert(facets[0].corners.begin(), i);
    facets[1].corners.push_back(n + i);
    facets.push_back({"side-" + std::to_string(i), {i, next, n + next, n + i}});
  }
  return polyhedron(corners, facets);
}

TEST(Polyhedron, IsMeshedExactly) {
  for (const Complex& complex : {tetrahedron(), wedge(), step()}) {
    const Body body(complex);
    input::Mesh mesh = testing::mesh(1, 1);
    mesh.min_quality = 0.15;
    const MotherPoints base = make_mother_points(body, mesh, 5);
    for (std::uint64_t sample = 0; sample < 3; ++sample) {
      // Verifies the volume and the area of each face to 1e-12.
      const Realization made = make_realization(body, base, mesh, 5, sample);
      double volume = 0;
      for (const Tetrahedron& t : made.tetrahedra)
        volume += signed_volume(made.nodes[index(t[0])], made.nodes[index(t[1])], made.nodes[index(t[2])],
                                made.nodes[index(t[3])]);
      EXPECT_NEAR(volume, body.volume(), 1e-12 * body.volume());
      EXPECT_GT(made.nodes.size(), 100u);
      for (std::size_t i = 0; i < base.size(); ++i) {
        const PlaceId place = body.place_of(base.position[i]);
        EXPECT_EQ(body.place_of(made.nodes[i]), place);
        EXPECT_EQ(made.nodes[i] == base.position[i], body.directions(place).n == 0);
      }
    }
  }
}

TEST(Polyhedron, PlacesPoints) {
  const Body body(tetrahedron());
  EXPECT_NEAR(
      body.volume(),
      std::abs(signed_volume(body.corners()[0], body.corners()[1], body.corners()[2], body.corners()[3])),
      1e-12 * body.volume());
  const Point middle = (body.corners()[0] + body.corners()[1] + body.corners()[2] + body.corners()[3]) / 4;
  EXPECT_EQ(body.place_of(middle), in_interior);
  EXPECT_EQ(body.place_of(body.bounds().upper), out_of_body);
  EXPECT_EQ(body.edges().size(), 6u);
  for (const Point& corner : body.corners()) EXPECT_EQ(body.directions(body.place_of(corner)).n, 0);
  for (const Edge& edge : body.edges()) {
    const Directions along = body.directions(body.place_of(edge.at(edge.length() / 3)));
    ASSERT_EQ(along.n, 1);
    EXPECT_NEAR(std::abs(dot(along.vector[0], edge.direction())), 1, 1e-15);
    EXPECT_EQ(std::popcount(along.mask()), 1);
  }
  for (std::size_t id = 0; id < body.faces().size(); ++id) {
    const Face& face = body.faces()[id];
    const Point inside = middle - dot(middle - face.patch.origin, face.outward) * face.outward;
    ASSERT_TRUE(body.in_face(static_cast<FaceId>(id), inside));
    EXPECT_EQ(body.place_of(inside), static_cast<FaceId>(id));
    EXPECT_EQ(body.directions(static_cast<FaceId>(id)).n, 2);
    EXPECT_LE(body.distance_to_surface(0.5 * (middle + inside)), norm(middle - inside) / 2 + 1e-15);
    const auto through = body.passage(static_cast<FaceId>(id), middle, inside + (inside - middle), 0);
    ASSERT_TRUE(through);
    EXPECT_NEAR(norm(*through - inside), 0, 1e-15);
  }
  EXPECT_EQ(body.symmetries().size(), 1u);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::geometry
