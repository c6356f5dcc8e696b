// SPDX-License-Identifier: GPL-3.0-or-later
// A body and its cracks rotated in the y-z plane: no measure of the analysis may depend on the axes.
#include "common/real.h"
#include "cracks/crack_line.h"
#include "cracks/crack_pattern.h"
#include "cracks/crack_speed.h"
#include "cracks/front_trajectory.h"
#include "cracks/section_crossings.h"
#include "support/structured_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

namespace crackle::cracks {
namespace CRACKLE_TEST_FILE {

using geometry::Point;

/// Rotated by 35 degrees, with a shift that keeps the body at positive coordinates.
Vector turned(const Vector& v) {
  const double c = std::cos(0.61);
  const double s = std::sin(0.61);
  return {v[0], c * v[1] - s * v[2], s * v[1] + c * v[2]};
}
Point moved(const Point& p) {
  const Point q = turned(p);
  return {q[0], q[1] + 30, q[2] + 1};
}

/// The analysis data of a body, rotated.
geometry::Complex turned_body(const geometry::Body& body) {
  geometry::Complex complex;
  complex.bounds = {{0, 0, 0}, {body.size()[0], 60, 60}};
  complex.crack_starts = body.crack_starts();
  for (geometry::CrackStart& start : complex.crack_starts) {
    start.tip = moved(start.tip);
    start.end = moved(start.end);
    start.along = turned(start.along);
    start.across = turned(start.across);
  }
  return complex;
}

class Turned : public ::testing::Test {
protected:
  /// Cracks in the planes of both notches up to these y, that of notch 0 with a bend.
  CrackSurface cracks(double end_0, double end_1) const {
    const auto label = [](const Point& p) {
      return p[2] > 15.5 ? 2 : p[2] > 8.5 + std::max(0.0, p[1] - 9) / 4 ? 1 : 0;
    };
    const auto time = [=](const Point& p) {
      const bool first = p[2] < 13 && p[1] > 4 && p[1] < end_0;
      const bool second = p[2] > 13 && p[1] < 12 && p[1] > end_1;
      return first ? (p[1] - 4) / 500 : second ? (12 - p[1]) / 300 : -1.0;
    };
    return make_crack_surface(mesh.body(), mesh.realization(), mesh.break_between(label, time), 0);
  }
  static CrackSurface moved_surface(CrackSurface surface) {
    for (CrackFacet& facet : surface.facets)
      for (Point& corner : facet.corner) corner = moved(corner);
    return surface;
  }

  test::StructuredMesh mesh{test::notched_plate()};
  geometry::Body body{turned_body(mesh.body())};
};

TEST_F(Turned, CracksComeAsFar) {
  const CrackSurface surface = cracks(14, 3);
  const CrackSurface other = moved_surface(surface);
  EXPECT_EQ(crossed_shares(mesh.body(), surface), crossed_shares(body, other));
  EXPECT_GT(crossed_shares(body, other)[0], 0.8);
  EXPECT_EQ(leading_start(body, other), leading_start(mesh.body(), surface));
  EXPECT_DOUBLE_EQ(path_overlap(body, other, 0, 1), path_overlap(mesh.body(), surface, 0, 1));
  EXPECT_GT(path_overlap(body, other, 0, 1), 0.5);
  EXPECT_EQ(classify(body, other), Pattern::two_cracks);
  const double speed =
      max_crack_speed(mesh.body(), front_trajectories(mesh.body(), surface, infinity)).largest;
  EXPECT_NEAR(max_crack_speed(body, front_trajectories(body, other, infinity)).largest, speed, 1e-6 * speed);
}

TEST_F(Turned, LinesAreTurnedToo) {
  const CrackSurface surface = cracks(14, 3);
  const CrackSurface other = moved_surface(surface);
  const auto lines = crack_lines(mesh.body(), surface, find_branches(mesh.body(), surface));
  const auto others = crack_lines(body, other, find_branches(body, other));
  ASSERT_EQ(lines.size(), others.size());
  ASSERT_GE(lines.size(), 2u);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    EXPECT_NEAR(others[i].bend, lines[i].bend, 1e-9);
    ASSERT_EQ(others[i].points.size(), lines[i].points.size());
    for (std::size_t k = 0; k < lines[i].points.size(); ++k) {
      const Point p = moved({0, lines[i].points[k].y, lines[i].points[k].z});
      EXPECT_NEAR(others[i].points[k].y, p[1], 1e-9);
      EXPECT_NEAR(others[i].points[k].z, p[2], 1e-9);
    }
  }
}

// The crossing lies at the intersection of the section's plane and the crack's plane.
TEST_F(Turned, SectionsCutAcrossTheLigament) {
  const CrackSurface surface = moved_surface(cracks(8, 12));
  const Point place = moved({0, 6, 8.5});
  const input::Sections sections{.y = {place[1]}, .z = {place[2]}};
  const auto crossings = section_crossings(body, surface, find_branches(body, surface), planes_of(sections));
  ASSERT_EQ(crossings.size(), 4u);
  EXPECT_NEAR(crossings[0].position, place[2], 0.1);
  EXPECT_TRUE(std::isnan(crossings[1].position)) << "35 degrees from the ligament";
  EXPECT_TRUE(std::isnan(crossings[2].position));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::cracks
