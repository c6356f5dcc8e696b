// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/geometry/body.h"

#include "crackle/geometry/quality.h"
#include "support/geometry_bodies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace crackle::geometry {
namespace {

using input::Face;
using testing::body;
using ::testing::HasSubstr;
using testing::mm;
using testing::notch;
using ::testing::Throws;
using ::testing::ThrowsMessage;

TEST(Body, BoxWithoutNotches) {
  const Body box = body({2, 3, 5});
  EXPECT_NEAR(box.volume(), 30 * mm * mm * mm, 1e-24);
  ASSERT_EQ(box.surfaces().size(), 6u);
  const std::array<double, 6> area{15, 15, 10, 10, 6, 6};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(box.surfaces()[i].area, area[i] * mm * mm, 1e-20);
    EXPECT_EQ(box.surfaces()[i].axis, static_cast<int>(i) / 2);
    EXPECT_EQ(box.surfaces()[i].outward, i % 2 == 0 ? -1 : 1);
    EXPECT_EQ(box.surfaces()[i].position, i % 2 == 0 ? 0.0 : box.size()[i / 2]);
  }
  EXPECT_EQ(box.edges().size(), 12u);
  EXPECT_EQ(box.corners().size(), 8u);
  EXPECT_EQ(box.distance_to_notch_tip({0, 0, 0}), std::numeric_limits<double>::infinity());
}

TEST(Body, NotchOnEachFace) {
  const Body notched = testing::four_notches();
  const double slots = 2 * (2 * 0.5 + 3 * 0.8 + 2 * 0.4 + 1 * 1.5);
  EXPECT_NEAR(notched.volume(), (2 * 10 * 12 - slots) * mm * mm * mm, 1e-21);
  ASSERT_EQ(notched.surfaces().size(), 18u);
  EXPECT_NEAR(notched.surfaces()[0].area, (10 * 12 - slots / 2) * mm * mm, 1e-18);  // x-min
  EXPECT_NEAR(notched.surfaces()[2].area, (2 * 12 - 2 * 0.5) * mm * mm, 1e-18);     // y-min
  EXPECT_NEAR(notched.surfaces()[5].area, (2 * 10 - 2 * 1.5) * mm * mm, 1e-18);     // z-max
  // The notch in y-max: walls across z, tip across y at 10 - 3 mm with the body below it.
  EXPECT_EQ(notched.surfaces()[9].axis, 2);
  EXPECT_EQ(notched.surfaces()[9].outward, 1);
  EXPECT_EQ(notched.surfaces()[10].outward, -1);
  EXPECT_EQ(notched.surfaces()[11].axis, 1);
  EXPECT_DOUBLE_EQ(notched.surfaces()[11].position, 7 * mm);
  EXPECT_EQ(notched.surfaces()[11].outward, 1);
  EXPECT_NEAR(notched.surfaces()[11].area, 2 * 0.8 * mm * mm, 1e-20);
  EXPECT_EQ(Body::notch_of(5), -1);
  EXPECT_EQ(Body::notch_of(8), 0);
  EXPECT_EQ(Body::notch_of(9), 1);
}

// The divergence theorem: the exact outward areas of each axis cancel, and their first moments give the
// volume.
TEST(Body, SurfacesEncloseTheVolume) {
  for (const Body& any : {body({2, 3, 5}), testing::short_plate(), testing::four_notches()}) {
    for (int axis = 0; axis < 3; ++axis) {
      double flux = 0;
      double volume = 0;
      for (const Surface& surface : any.surfaces()) {
        if (surface.axis != axis) continue;
        flux += surface.outward * surface.area;
        volume += surface.outward * surface.area * surface.position;
      }
      EXPECT_NEAR(flux, 0, 1e-12 * any.surfaces()[0].area);
      EXPECT_NEAR(volume, any.volume(), 1e-12 * any.volume());
    }
  }
}

// Euler's formula for edges and corners: three edges end at every corner of a box with slots.
TEST(Body, ThreeEdgesEndAtEachCorner) {
  for (const Body& any : {body({2, 3, 5}), testing::short_plate(), testing::four_notches()}) {
    EXPECT_EQ(any.edges().size() * 2, any.corners().size() * 3);
    for (const Point& corner : any.corners()) {
      EXPECT_EQ(any.movable_axes(corner), 0);
      int ends = 0;
      for (const Edge& edge : any.edges()) ends += (edge.from == corner) + (edge.to == corner);
      EXPECT_EQ(ends, 3);
    }
  }
}

TEST(Body, MovableAxes) {
  const Body notched = body({2, 10, 12}, {notch(Face::y_min, 6, 2, 0.5)});
  const SlotSection& slot = notched.sections()[0];
  const double y = 1 * mm;
  EXPECT_EQ(notched.movable_axes({mm, y, mm}), 7);
  EXPECT_EQ(notched.movable_axes({0, y, mm}), 6);
  EXPECT_EQ(notched.movable_axes({mm, y, slot.lower}), 3);
  EXPECT_EQ(notched.movable_axes({2 * mm, y, slot.upper}), 2);
  EXPECT_EQ(notched.movable_axes({mm, slot.tip, 6 * mm}), 5);
  EXPECT_EQ(notched.movable_axes({mm, slot.tip, slot.upper}), 1);
  EXPECT_EQ(notched.movable_axes({mm, 3 * mm, slot.lower}), 7);  // beyond the tip: no surface there
  EXPECT_EQ(notched.movable_axes({mm, std::nextafter(slot.tip, 1), 6 * mm}), 7);
}

TEST(Body, ContainsAndDistances) {
  const Body notched = body({2, 10, 12}, {notch(Face::y_max, 6, 2, 0.5)});
  EXPECT_TRUE(notched.contains({0, 0, 0}));
  EXPECT_TRUE(notched.contains({mm, 8 * mm, 6 * mm}));
  EXPECT_FALSE(notched.contains({mm, 8.1 * mm, 6 * mm}));
  EXPECT_TRUE(notched.contains({mm, 8.1 * mm, notched.sections()[0].lower}));
  EXPECT_FALSE(notched.contains({mm, 1 * mm, 12.001 * mm}));
  EXPECT_NEAR(notched.distance_to_notch_tip({mm, 5 * mm, 6 * mm}), 3 * mm, 1e-15);
  EXPECT_NEAR(notched.distance_to_notch_tip({mm, 8 * mm, 7.25 * mm}), 1 * mm, 1e-15);
  EXPECT_NEAR(notched.distance_to_surface({mm, 5 * mm, 6 * mm}), 1 * mm, 1e-15);
  EXPECT_NEAR(notched.distance_to_surface({mm, 7.7 * mm, 6 * mm}), 0.3 * mm, 1e-15);
}

TEST(Body, RefusesWhatIsNoNotchedBox) {
  EXPECT_THAT([] { body({0, 3, 5}); }, ThrowsMessage<std::runtime_error>(HasSubstr("positive")));
  EXPECT_THAT(
      [] {
        body({2, 10, 12}, {notch(Face::x_min, 6, 1, 0.5)});
      },
      ThrowsMessage<std::runtime_error>(HasSubstr("y-min, y-max, z-min or z-max")));
  EXPECT_THAT(
      [] {
        body({2, 10, 12}, {notch(Face::y_min, 0.2, 1, 0.5)});
      },
      ThrowsMessage<std::runtime_error>(HasSubstr("does not lie inside the face")));
  EXPECT_THAT(
      [] {
        body({2, 10, 12}, {notch(Face::z_max, 9.9, 1, 0.5)});
      },
      ThrowsMessage<std::runtime_error>(HasSubstr("notch 1 (z-max)")));
  EXPECT_THAT(
      [] {
        body({2, 10, 12}, {notch(Face::y_min, 6, 10, 0.5)});
      },
      ThrowsMessage<std::runtime_error>(HasSubstr("cuts the body in two")));
  EXPECT_THAT(
      [] {
        body({2, 10, 12}, {notch(Face::y_min, 6, 2, 0)});
      },
      ThrowsMessage<std::runtime_error>(HasSubstr("must be positive")));
  // Overlap, contact, and a cut through the body by two notches of opposite faces.
  EXPECT_THAT(
      [] {
        body({2, 10, 12}, {notch(Face::y_min, 6, 2, 1), notch(Face::y_min, 6.5, 1, 1)});
      },
      ThrowsMessage<std::runtime_error>(HasSubstr("notch 1 (y-min) and notch 2 (y-min) overlap")));
  EXPECT_THAT(
      [] {
        body({2, 10, 12}, {notch(Face::y_min, 6, 6, 1), notch(Face::y_max, 6, 5, 1)});
      },
      Throws<std::runtime_error>());
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

}  // namespace
}  // namespace crackle::geometry
