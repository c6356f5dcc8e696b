// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_line.h"

#include "crackle/analysis/crack_path.h"
#include "support/structured_mesh.h"

#include <gmock/gmock.h>

#include <cmath>

namespace crackle::analysis {
namespace {

using geometry::Point;
using test::StructuredMesh;

/// The plate of the tests of crack paths, 40 wide: notch 0 has its tip at y = 4 and its plane at z = 8.5.
class Lines : public testing::Test {
protected:
  static input::Specimen wide_plate() {
    return {{4, 40, 36}, {{input::Face::y_min, 8.5, 4, 1}, {input::Face::y_max, 27.5, 4, 1}}};
  }
  std::vector<CrackLine> lines(const std::function<int(const Point&)>& label,
                               const std::function<double(const Point&)>& time) const {
    return crack_lines(
        mesh.body(), make_crack_surface(mesh.body(), mesh.realization(), mesh.break_between(label, time), 0));
  }
  static double growing(const Point& p) { return p[1] > 4 ? (p[1] - 4) / 500 : -1; }

  StructuredMesh mesh{wide_plate()};
};

TEST_F(Lines, AStraightCrackIsAStraightLine) {
  const auto found = lines([](const Point& p) { return p[2] > 8.5 ? 1 : 0; }, growing);
  ASSERT_EQ(found.size(), 1u);
  const CrackLine& line = found[0];
  std::printf("%zu points from y = %.2f to %.2f, bend %.2e\n", line.points.size(), line.points.front().y,
              line.points.back().y, line.bend);
  EXPECT_EQ(line.notch, 0);
  EXPECT_EQ(line.parent, -1);
  EXPECT_EQ(line.kinks, 0);
  EXPECT_NEAR(line.bend, 0, 0.01);
  EXPECT_LT(line.points.front().y, 5.5);
  EXPECT_GT(line.points.back().y, 38.5);
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    EXPECT_NEAR(line.points[i].z, 8.5, 0.15);  // the cubes' roughness
    EXPECT_NEAR(line.points[i].time, (line.points[i].y - 4) / 500, 2.0 / 500);
    EXPECT_TRUE(i == 0 || line.points[i].y > line.points[i - 1].y);
  }
}

TEST_F(Lines, AKinkIsSharpAndABendIsNot) {
  // A turn of 45 degrees at y = 20, at once and along an arc of radius 25.
  const auto kinked = [](double y) { return std::max(0.0, y - 20); };
  const auto bent = [](double y) {
    const double s = std::min(std::max(0.0, y - 8), 25 / std::sqrt(2.0));
    return 25 - std::sqrt(25 * 25 - s * s) + std::max(0.0, y - 8 - s);
  };
  const double angle = std::atan(1.0);
  for (const bool sharp : {true, false}) {
    mesh.map_nodes([&](const Point& p) {
      return Point{p[0], p[1], p[2] + (sharp ? kinked(p[1]) : bent(p[1]))};
    });
    const auto found = lines([](const Point& p) { return p[2] > 8.5 ? 1 : 0; }, growing);
    ASSERT_EQ(found.size(), 1u);
    std::printf("%s: %d kinks, bend %.1f degrees\n", sharp ? "kinked" : "bent", found[0].kinks,
                found[0].bend * 180 / M_PI);
    EXPECT_EQ(found[0].kinks, sharp ? 1 : 0);
    EXPECT_EQ(count_kinks(found), found[0].kinks);
    EXPECT_NEAR(found[0].bend, angle, 0.06);
  }
}

TEST_F(Lines, ABranchLeavesItsParent) {
  // A fork at y = 16.5; the upper branch ends at y = 30, where the longer one stays the main line.
  const auto fork = [](const Point& p) { return p[2] > (p[1] > 16.5 ? 14.5 : 8.5) ? 2 : p[2] > 8.5 ? 1 : 0; };
  const auto time = [](const Point& p) { return p[2] > 12 && p[1] > 30 ? -1.0 : growing(p); };
  const auto found = lines(fork, time);
  ASSERT_EQ(found.size(), 2u);
  std::printf("main line to (%.1f, %.1f), branch from (%.1f, %.1f) to (%.1f, %.1f)\n",
              found[0].points.back().y, found[0].points.back().z, found[1].points.front().y,
              found[1].points.front().z, found[1].points.back().y, found[1].points.back().z);
  EXPECT_EQ(found[0].parent, -1);
  EXPECT_EQ(found[1].parent, 0);
  EXPECT_GT(found[0].points.back().y, 38.5);
  EXPECT_NEAR(found[0].points.back().z, 8.5, 0.2);
  EXPECT_LT(found[1].points.front().y, 18);
  EXPECT_NEAR(found[1].points.back().y, 30, 1.5);
  EXPECT_NEAR(found[1].points.back().z, 14.5, 0.2);
}

TEST_F(Lines, NothingWithoutCracks) {
  EXPECT_TRUE(crack_lines(mesh.body(), CrackSurface{}).empty());
}

}  // namespace
}  // namespace crackle::analysis
