// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/body.h"

#include "geometry/quality.h"
#include "support/geometry_bodies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numbers>

namespace crackle::geometry {
namespace CRACKLE_TEST_FILE {

using plane::Face;
using testing::body;
using ::testing::HasSubstr;
using testing::mm;
using testing::notch;
using ::testing::ThrowsMessage;

TEST(Body, BoxWithoutNotches) {
  const Body box = body({2, 3, 5});
  EXPECT_NEAR(box.volume(), 30 * mm * mm * mm, 1e-24);
  EXPECT_EQ(box.size(), (Point{2 * mm, 3 * mm, 5 * mm}));
  ASSERT_EQ(box.faces().size(), 6u);
  const std::array<double, 6> area{15, 15, 10, 10, 6, 6};
  for (std::size_t i = 0; i < 6; ++i) {
    const auto ids = box.faces_named(plane::face_names[i]);
    ASSERT_EQ(ids.size(), 1u);
    const auto& face = box.faces()[index(ids[0])];
    EXPECT_NEAR(face.area, area[i] * mm * mm, 1e-20);
    EXPECT_EQ(face.outward[i / 2], i % 2 == 0 ? -1 : 1);
    EXPECT_EQ(norm(face.outward), 1);
    EXPECT_EQ(face.patch.bounds().lower[i / 2], i % 2 == 0 ? 0.0 : box.size()[i / 2]);
    EXPECT_EQ(face.patch.bounds().upper[i / 2], face.patch.bounds().lower[i / 2]);
  }
  EXPECT_EQ(box.edges().size(), 12u);
  EXPECT_EQ(box.corners().size(), 8u);
  EXPECT_TRUE(box.crack_starts().empty());
  EXPECT_EQ(box.outline(), (std::vector<Polygon>{{{0, 0}, {3 * mm, 0}, {3 * mm, 5 * mm}, {0, 5 * mm}}}));
}

TEST(Body, NotchOnEachFace) {
  const Body notched = testing::four_notches();
  const double slots = 2 * (2 * 0.5 + 3 * 0.8 + 2 * 0.4 + 1 * 1.5);
  EXPECT_NEAR(notched.volume(), (2 * 10 * 12 - slots) * mm * mm * mm, 1e-21);
  const auto& faces = notched.faces();
  ASSERT_EQ(faces.size(), 22u);
  const auto area = [&](const char* name) {
    double sum = 0;
    for (const FaceId id : notched.faces_named(name)) sum += faces[index(id)].area;
    return sum;
  };
  EXPECT_NEAR(area("x-min"), (10 * 12 - slots / 2) * mm * mm, 1e-18);
  EXPECT_NEAR(area("y-min"), (2 * 12 - 2 * 0.5) * mm * mm, 1e-18);
  EXPECT_NEAR(area("z-max"), (2 * 10 - 2 * 1.5) * mm * mm, 1e-18);
  // The notch in y-max: walls normal to z, tip normal to y at 10 - 3 mm with the body below it.
  const testing::SlotFaces slot = testing::slot_faces(notched, 1);
  EXPECT_EQ(faces[index(slot.lower_wall)].outward, (Vector{0, 0, 1}));
  EXPECT_EQ(faces[index(slot.upper_wall)].outward, (Vector{0, 0, -1}));
  const geometry::Face& tip = faces[index(slot.tip_face)];
  EXPECT_EQ(tip.outward, (Vector{0, 1, 0}));
  EXPECT_DOUBLE_EQ(tip.patch.bounds().lower[1], 7 * mm);
  EXPECT_NEAR(tip.area, 2 * 0.8 * mm * mm, 1e-20);
}

/// Named like those of an outline that starts at the origin, counter-clockwise.
TEST(Body, FacesOfABoxAreItsEdgesToo) {
  const Body box = testing::four_notches();
  const std::array<const char*, 4> faces{"z-min", "y-max", "z-max", "y-min"};
  for (std::size_t i = 0; i < faces.size(); ++i)
    EXPECT_EQ(box.faces_named("edge-" + std::to_string(i)), box.faces_named(faces[i]));
  EXPECT_TRUE(box.faces_named("edge-4").empty());
}

TEST(Body, FacesByNameAndByTriangle) {
  const Body notched = testing::four_notches();
  using Ids = std::vector<FaceId>;
  // Round the plate after x-min and x-max: z-min, its notch 2, z-min again, y-max, its notch 1 and so on.
  EXPECT_EQ(notched.faces_named("x-max"), Ids{1});
  EXPECT_EQ(notched.faces_named("z-min"), (Ids{2, 6}));
  EXPECT_EQ(notched.faces_named("notch-2"), (Ids{3, 4, 5}));
  EXPECT_EQ(notched.faces_named("notch-1"), (Ids{8, 9, 10}));
  EXPECT_EQ(notched.faces_named("z-max"), (Ids{12, 16}));
  EXPECT_EQ(notched.faces_named("y-min"), (Ids{17, 21}));
  EXPECT_EQ(notched.faces_named("notch-4"), Ids{});
  const double z = testing::slot_faces(notched, 0).lower;
  EXPECT_EQ(notched.face_of({{{0, mm, z}, {mm, mm, z}, {mm, 0, z}}}), 20);
  EXPECT_EQ(notched.face_of({{{0, 0, z}, {mm, 0, 0}, {mm, 0, z}}}), 21);
  EXPECT_THROW(notched.face_of({{{0, mm, z}, {mm, mm, z}, {mm, 5 * mm, z}}}), std::runtime_error)
      << "beyond the tip";
}

// The divergence theorem: the exact outward areas of each axis cancel, and their first moments give the
// volume.
TEST(Body, SurfacesEncloseTheVolume) {
  for (const Body& any : {body({2, 3, 5}), testing::short_plate(), testing::four_notches()}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double flux = 0;
      double volume = 0;
      for (const auto& face : any.faces()) {
        flux += face.outward[axis] * face.area;
        volume += face.outward[axis] * face.area * face.patch.bounds().lower[axis];
      }
      EXPECT_NEAR(flux, 0, 1e-12 * any.faces()[0].area);
      EXPECT_NEAR(volume, any.volume(), 1e-12 * any.volume());
    }
    // The same for the outline, in the plane.
    double twice = 0;
    for (const Polygon& polygon : any.outline())
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const auto& a = polygon[i];
        const auto& b = polygon[(i + 1) % polygon.size()];
        twice += a[0] * b[1] - a[1] * b[0];
      }
    EXPECT_NEAR(twice / 2, any.faces()[0].area, 1e-12 * any.faces()[0].area);
  }
}

// Euler's formula for edges and corners: three edges end at every corner of a box with slots.
TEST(Body, ThreeEdgesEndAtEachCorner) {
  for (const Body& any : {body({2, 3, 5}), testing::short_plate(), testing::four_notches()}) {
    EXPECT_EQ(any.edges().size() * 2, any.corners().size() * 3);
    for (const Point& corner : any.corners()) {
      EXPECT_EQ(any.movable(corner), 0);
      int ends = 0;
      for (const Edge& edge : any.edges()) ends += (edge.from() == corner) + (edge.to() == corner);
      EXPECT_EQ(ends, 3);
    }
    for (const Edge& edge : any.edges()) {
      EXPECT_EQ(edge.at(0), edge.from());
      const auto movable = any.movable(edge.at(edge.length() / 3));
      EXPECT_EQ(std::popcount(movable), 1);
      const Directions along = any.directions(any.place_of(edge.at(edge.length() / 3)));
      ASSERT_EQ(along.n, 1);
      EXPECT_EQ(std::abs(dot(along.vector[0], edge.to() - edge.from())), edge.length());
    }
  }
}

TEST(Body, PatchAnywhereInSpace) {
  // A rectangle of 3 by 2 oriented along (4, 3) / 5 in the y-z plane.
  const Patch patch{{{0, 0, 0}, {3, 2, 0}}, {1, 1, 1}, {{{1, 0, 0}, {0, 0.8, 0.6}, {0, -0.6, 0.8}}}};
  const Point far = patch.at({3, 2, 0});
  EXPECT_EQ(far[0], 4);
  EXPECT_NEAR(far[1], 2.6, 1e-15);
  EXPECT_NEAR(far[2], 2.2, 1e-15);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(patch.bounds().lower[i], 1);
    EXPECT_EQ(patch.bounds().upper[i], far[i]);
  }
}

TEST(Body, CrackStartsAtEachTip) {
  const Body notched = testing::four_notches();
  ASSERT_EQ(notched.crack_starts().size(), 4u);
  const CrackStart& upper = notched.crack_starts()[1];  // in y-max at z = 5 mm, 3 mm deep
  EXPECT_EQ(upper.name, "notch 2");
  const testing::SlotFaces slot = testing::slot_faces(notched, 1);
  EXPECT_EQ(upper.tip, (Point{mm, slot.tip, 5 * mm}));
  EXPECT_EQ(upper.end, (Point{mm, 0, 5 * mm}));
  EXPECT_DOUBLE_EQ(upper.ligament, 7 * mm);
  EXPECT_NEAR(upper.advance({0, 4 * mm, 9 * mm}), 3 * mm, 1e-18);
  const CrossPlane plane = upper.plane_at(3 * mm);
  EXPECT_NEAR(plane.position, 4 * mm, 1e-18);
  EXPECT_EQ(plane.at(2 * mm), (Point{0, plane.position, 2 * mm}));
  EXPECT_NEAR(upper.advance_to(plane_of({1, 4 * mm})).value(), 3 * mm, 1e-18);
  EXPECT_FALSE(upper.advance_to(plane_of({2, 4 * mm})));
  // As far behind the tip as the notch is high.
  EXPECT_TRUE(upper.claims(slot.lower_wall, {mm, 7.7 * mm, slot.lower}));
  EXPECT_FALSE(upper.claims(slot.lower_wall, {mm, 7.9 * mm, slot.lower}));
  EXPECT_FALSE(upper.claims(notched.faces_named("y-max")[0], {mm, 7.7 * mm, slot.lower}));
}

TEST(Body, ALigamentEndsAtTheNextNotch) {
  const Body ahead = body({2, 20, 30}, {notch(Face::y_min, 15, 7, 1), notch(Face::y_max, 15.4, 6, 1),
                                        notch(Face::z_max, 10, 4, 2), notch(Face::z_min, 15, 4, 2)});
  const auto starts = ahead.crack_starts();
  EXPECT_DOUBLE_EQ(starts[0].ligament, 7 * mm);
  EXPECT_DOUBLE_EQ(starts[0].end[1], 14 * mm);
  EXPECT_DOUBLE_EQ(starts[1].ligament, 7 * mm);
  EXPECT_DOUBLE_EQ(starts[1].end[1], 7 * mm);
  EXPECT_DOUBLE_EQ(starts[2].ligament, 26 * mm) << "no slot lies ahead";
  EXPECT_DOUBLE_EQ(starts[3].end[2], 14.9 * mm) << "the side of a slot in another face";
}

// A ligament oblique to the axes.
TEST(Body, ObliqueCrackStart) {
  CrackStart start{};
  start.tip = {0, 1, 2};
  start.along = {0, 0.8, 0.6};
  start.across = {0, -0.6, 0.8};
  start.direction = 1;
  EXPECT_NEAR(start.advance({5, 1.8, 2.6}), 1, 1e-15);
  EXPECT_NEAR(start.advance({5, 0.4, 2.8}), 0, 1e-15) << "across";
  const CrossPlane plane = start.plane_at(1);
  EXPECT_NEAR(dot(plane.at(7), plane.normal), plane.position, 1e-15);
  EXPECT_NEAR(dot(plane.at(7), plane.across), 7, 1e-15);
  EXPECT_NEAR(start.advance_to(plane_of({1, 3})).value(), 2.5, 1e-15);
  EXPECT_FALSE(start.advance_to(plane_of({2, 3})));
}

TEST(Body, SnapsPointsAndFindsPassages) {
  const Body notched = body({2, 10, 12}, {notch(Face::y_min, 6, 2, 0.5)});
  const testing::SlotFaces slot = testing::slot_faces(notched, 0);
  const double e = 1e-12;
  EXPECT_EQ(notched.snapped({mm, mm, mm}, 2 * e), (Point{mm, mm, mm}));
  EXPECT_EQ(notched.snapped({e, 10 * mm - e, mm}, 2 * e), (Point{0, 10 * mm, mm}));
  EXPECT_EQ(notched.snapped({mm, slot.tip + e, slot.upper - e}, 2 * e), (Point{mm, slot.tip, slot.upper}));
  EXPECT_EQ(notched.snapped({mm, 3 * mm, slot.upper - e}, 2 * e), (Point{mm, 3 * mm, slot.upper - e}));

  const Point below{mm, mm, slot.lower - 0.1 * mm};
  const Point above{mm, 1.4 * mm, slot.upper + 0.1 * mm};
  const auto through = notched.passage(slot.lower_wall, below, above, 0);
  ASSERT_TRUE(through);
  EXPECT_EQ((*through)[2], slot.lower);
  EXPECT_EQ(notched.movable(*through), 3);
  EXPECT_FALSE(notched.passage(slot.tip_face, below, above, 0));
  EXPECT_FALSE(notched.passage(slot.lower_wall, above, {mm, 3 * mm, slot.upper}, 0)) << "on one side";
  const auto snapped = notched.passage(slot.lower_wall, below, above, 0.95 * mm);
  ASSERT_TRUE(snapped);
  EXPECT_EQ(notched.movable(*snapped), 1) << "on the edge of wall and tip";
}

TEST(Body, PlacesTetrahedra) {
  const Body notched = body({2, 10, 12}, {notch(Face::y_min, 6, 2, 0.5)});
  const testing::SlotFaces slot = testing::slot_faces(notched, 0);
  const auto with = [&](double y, double z) {  // two corners on the tip, two here
    return notched.classify(
        {{{mm, slot.tip, slot.lower}, {mm, slot.tip, slot.upper}, {0, y, z}, {2 * mm, y, z}}});
  };
  EXPECT_EQ(with(3 * mm, 6 * mm), Containment::inside);
  EXPECT_EQ(with(mm, 6 * mm), Containment::outside);
  EXPECT_EQ(with(mm, slot.upper), Containment::outside);
  EXPECT_EQ(with(mm, 7 * mm), Containment::straddling);
  // Across the edge of tip and wall, distinguishable only by their diagonals.
  const auto diagonal = [&](double y) {
    return notched.classify(
        {{{mm, y, 6.2 * mm}, {0, y, 6.2 * mm}, {mm, 1.8 * mm, 6.5 * mm}, {0, 1.8 * mm, 7 * mm}}});
  };
  EXPECT_EQ(diagonal(2.5 * mm), Containment::inside);
  EXPECT_EQ(diagonal(2.01 * mm), Containment::straddling);
}

TEST(Body, Movable) {
  const Body notched = body({2, 10, 12}, {notch(Face::y_min, 6, 2, 0.5)});
  const testing::SlotFaces slot = testing::slot_faces(notched, 0);
  const double y = 1 * mm;
  EXPECT_EQ(notched.movable({mm, y, mm}), 7);
  EXPECT_EQ(notched.movable({0, y, mm}), 6);
  EXPECT_EQ(notched.movable({mm, y, slot.lower}), 3);
  EXPECT_EQ(notched.movable({2 * mm, y, slot.upper}), 2);
  EXPECT_EQ(notched.movable({mm, slot.tip, 6 * mm}), 5);
  EXPECT_EQ(notched.movable({mm, slot.tip, slot.upper}), 1);
  EXPECT_EQ(notched.movable({mm, 3 * mm, slot.lower}), 7);  // beyond the tip there is no surface
  EXPECT_EQ(notched.movable({mm, std::nextafter(slot.tip, 1), 6 * mm}), 7);
}

TEST(Body, ContainsAndDistances) {
  const Body notched = body({2, 10, 12}, {notch(Face::y_max, 6, 2, 0.5)});
  EXPECT_TRUE(notched.contains({0, 0, 0}));
  EXPECT_TRUE(notched.contains({mm, 8 * mm, 6 * mm}));
  EXPECT_FALSE(notched.contains({mm, 8.1 * mm, 6 * mm}));
  EXPECT_TRUE(notched.contains({mm, 8.1 * mm, testing::slot_faces(notched, 0).lower}));
  EXPECT_FALSE(notched.contains({mm, 1 * mm, 12.001 * mm}));
  EXPECT_NEAR(notched.distance_to_surface({mm, 5 * mm, 6 * mm}), 1 * mm, 1e-15);
  EXPECT_NEAR(notched.distance_to_surface({mm, 7.7 * mm, 6 * mm}), 0.3 * mm, 1e-15);
  const auto beside = notched.faces_named("y-max");
  ASSERT_EQ(beside.size(), 2u);
  EXPECT_NEAR(notched.distance_to_outline(beside[1], {mm, 10 * mm, 7 * mm}), 0.75 * mm, 1e-15)
      << "from the mouth";
  for (const FaceId face : beside)
    EXPECT_LE(notched.distance_to_outline(face, {mm, 10 * mm, 6 * mm}), 0) << "in the mouth";
  const FaceId tip = testing::slot_faces(notched, 0).tip_face;
  EXPECT_NEAR(notched.distance_to_outline(tip, {mm, 8 * mm, 6.05 * mm}), 0.2 * mm, 1e-15);
}

TEST(Body, RefusesABoxThatDoesNotExist) {
  const auto refused = [](const Vector& size, std::vector<plane::Notch> notches, const char* why) {
    EXPECT_THAT([&] { body(size, notches); }, ThrowsMessage<std::runtime_error>(HasSubstr(why)));
  };
  refused({0, 3, 5}, {}, "positive");
  refused({2, 10, 12}, {notch(Face::x_min, 6, 1, 0.5)}, "y-min, y-max, z-min or z-max");
  refused({2, 10, 12}, {notch(Face::z_max, 6, 1, 0.5), notch(Face::y_min, 6, 2, 0)}, "notch 2 (y-min)");
  refused({2, 10, 12}, {notch(Face::y_min, 6, -2, 0.5)}, "must be positive");
  refused({2, 10, 12}, {notch(Face::y_min, 0.2, 1, 0.5)}, "does not lie inside the face");
  refused({2, 10, 12}, {notch(Face::z_max, 9.9, 1, 0.5)}, "notch 1 (z-max)");
  refused({2, 10, 12}, {notch(Face::y_min, 6, 10, 0.5)}, "cuts the body in two");
  refused({2, 10, 12}, {notch(Face::y_min, 6, 11, 0.5)}, "cuts the body in two");
  // Overlap, contact, one in the other, and two in opposite faces that cut through the body.
  const char* const touch = "overlap or touch";
  refused({2, 10, 12}, {notch(Face::y_min, 6, 2, 1), notch(Face::y_min, 6.5, 1, 1)},
          "notch 1 (y-min) and notch 2 (y-min) overlap");
  refused({2, 8, 12}, {notch(Face::y_min, 4, 2, 2), notch(Face::y_min, 6, 1, 2)}, touch);
  refused({2, 10, 12}, {notch(Face::y_min, 6, 2, 1), notch(Face::y_min, 6, 1, 0.5)}, touch);
  refused({2, 10, 12}, {notch(Face::y_min, 6, 2, 1), notch(Face::z_min, 1, 7, 0.5)}, touch);
  refused({2, 10, 12}, {notch(Face::y_min, 6, 6, 1), notch(Face::y_max, 6, 5, 1)}, touch);
  EXPECT_NO_THROW(body({2, 10, 12}, {notch(Face::y_min, 6, 5, 1), notch(Face::y_max, 6, 4.5, 1)}));
}

TEST(Quality, RegularFlatAndInverted) {
  const double h = std::sqrt(3.0) / 2;
  const Point a{0, 0, 0};
  const Point b{1, 0, 0};
  const Point c{0.5, h, 0};
  const Point d{0.5, h / 3, std::sqrt(2.0 / 3)};
  EXPECT_NEAR(mean_ratio(a, b, c, d), 1, 1e-14);
  EXPECT_NEAR(mean_ratio_cubed(a, b, c, d), 1, 1e-14);
  EXPECT_NEAR(signed_volume(a, b, c, d), 1 / std::sqrt(72.0), 1e-15);
  EXPECT_EQ(mean_ratio(a, c, b, d), 0);
  EXPECT_EQ(mean_ratio(a, b, c, {0.2, 0.3, 0}), 0);
  for (const double angle : dihedral_angles(a, b, c, d)) EXPECT_NEAR(angle, std::acos(1.0 / 3), 1e-14);
}

// The right-angled corner of a cube: V = 1/6, squared edges 1, 1, 1, 2, 2, 2.
TEST(Quality, CornerOfACube) {
  const Point o{0, 0, 0};
  const double q = 12 * std::cbrt(0.25) / 9;
  EXPECT_NEAR(mean_ratio(o, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}), q, 1e-14);
  EXPECT_NEAR(mean_ratio_cubed(o, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}), q * q * q, 1e-14);
  const auto angles = dihedral_angles(o, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(angles[i], std::numbers::pi / 2, 1e-14);
  for (std::size_t i = 3; i < 6; ++i) EXPECT_NEAR(angles[i], std::acos(1 / std::sqrt(3.0)), 1e-14);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::geometry
