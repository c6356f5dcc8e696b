// SPDX-License-Identifier: GPL-3.0-or-later
#include "cracks/crack_line.h"

#include "support/effort.h"
#include "support/made_crack.h"
#include "support/structured_mesh.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace crackle::cracks {
namespace CRACKLE_TEST_FILE {

using geometry::Point;
using test::StructuredMesh;

/// The plate of the crack path tests, 40 wide: notch 0 has its tip at y = 4 and its plane at z = 8.5.
class Lines : public testing::Test {
protected:
  static plane::Specimen wide_plate() {
    return {{4, 40, 36}, {{plane::Face::y_min, 8.5, 4, 1}, {plane::Face::y_max, 27.5, 4, 1}}};
  }
  std::vector<CrackLine> lines(const std::function<int(const Point&)>& label,
                               const std::function<double(const Point&)>& time) const {
    const CrackSurface surface =
        make_crack_surface(mesh.body(), mesh.realization(), mesh.break_between(label, time), 0);
    return crack_lines(mesh.body(), surface, find_branches(mesh.body(), surface));
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
  EXPECT_EQ(line.start, 0);
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
  // A turn of 45 degrees at y = 20, abrupt or along an arc of radius 25.
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
  // Branching at y = 16.5; the upper branch ends at y = 30, where the longer one stays the main line.
  const auto branching = [](const Point& p) {
    return p[2] > (p[1] > 16.5 ? 14.5 : 8.5) ? 2 : p[2] > 8.5 ? 1 : 0;
  };
  const auto time = [](const Point& p) { return p[2] > 12 && p[1] > 30 ? -1.0 : growing(p); };
  const auto found = lines(branching, time);
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

/// A path of pieces with constant curvature [mm].
class Pieces {
public:
  struct Piece {
    double turn;       ///< at its start [degrees]
    double length;     ///< [mm]
    double curvature;  ///< [1/mm]
  };
  explicit Pieces(const std::vector<Piece>& pieces) {
    const double step = 0.01;
    double angle = 0;
    std::array<double, 2> p{0, 0};
    const auto advance = [&](double curvature) {
      points_.push_back(p);
      angle += curvature * step;
      p[0] += step * std::cos(angle);
      p[1] += step * std::sin(angle);
    };
    for (const Piece& piece : pieces) {
      angle += piece.turn * M_PI / 180;
      for (double s = 0; s < piece.length; s += step) advance(piece.curvature);
    }
    while (p[0] < test::MadeCrack::width) advance(0);  // straight on
    points_.push_back(p);
  }

  double operator()(double advance) const {
    const auto b = std::upper_bound(points_.begin() + 1, points_.end() - 1, advance,
                                    [](double value, const auto& q) { return value < q[0]; });
    const auto a = b - 1;
    return (*a)[1] + (advance - (*a)[0]) / ((*b)[0] - (*a)[0]) * ((*b)[1] - (*a)[1]);
  }
  double low() const { return (*std::min_element(points_.begin(), points_.end(), is_below))[1]; }
  double high() const { return (*std::max_element(points_.begin(), points_.end(), is_below))[1]; }

private:
  static bool is_below(const std::array<double, 2>& a, const std::array<double, 2>& b) { return a[1] < b[1]; }
  std::vector<std::array<double, 2>> points_;
};

TEST(Kinks, AreThoseOfThePathAtAnySpacing) {
  const double radius = 4;
  const auto arc = [=](double degrees) { return radius * degrees * M_PI / 180; };
  struct Case {
    const char* name;
    Pieces path;
    int n_kinks;
  };
  for (const Case& c :
       {Case{"arc of 45 degrees", Pieces{{{0, 4, 0}, {0, arc(45), 1 / radius}}}, 0},
        Case{"S of 40 degrees", Pieces{{{0, 4, 0}, {0, arc(40), 1 / radius}, {0, arc(40), -1 / radius}}}, 0},
        Case{"30 degrees", Pieces{{{0, 8, 0}, {30, 5, 0}}}, 1},
        Case{"45 degrees", Pieces{{{0, 8, 0}, {45, 5, 0}}}, 1},
        Case{"60 degrees", Pieces{{{0, 8, 0}, {60, 5, 0}}}, 1},
        Case{"40 degrees there and back", Pieces{{{0, 6, 0}, {40, 4, 0}, {-40, 3, 0}}}, 2}}) {
    for (const double spacing : {0.2, 0.29, 0.4, 0.5}) {
      if (spacing == 0.2 && !test::is_full()) continue;  // half of the time
      const test::MadeCrack crack(spacing, 2.5, 1, c.path, c.path.low(), c.path.high());
      const int found = count_kinks(
          crack_lines(crack.body(), crack.surface(), find_branches(crack.body(), crack.surface())));
      std::printf("%s at %g mm: %d kinks\n", c.name, spacing, found);
      EXPECT_EQ(found, c.n_kinks);
    }
  }
}

TEST_F(Lines, NothingWithoutCracks) {
  EXPECT_TRUE(crack_lines(mesh.body(), {}, {}).empty());
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::cracks
