// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/random.h"
#include "plane/shape.h"
#include "plane/side_index.h"
#include "plane/subdivision.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

namespace crackle::plane {
namespace CRACKLE_TEST_FILE {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

Shape square(double size) {
  return {{{{{0, 0}, {size, 0}, {size, size}, {0, size}}, {0, 1, 2, 3}}},
          {{"edge-0"}, {"edge-1"}, {"edge-2"}, {"edge-3"}, {"hole-0", true}, {"notch-0"}}};
}

Loop of_part(Polygon corners, int part) {
  const std::size_t n = corners.size();
  return {std::move(corners), std::vector<int>(n, part)};
}

/// A square with a round hole and a slanted slot from its left side.
Shape plate() {
  const Loop hole = of_part(arc({7, 7}, {1.5, 0}, {0, 1.5}, 4, [](const Point&) { return 0.4; }), 4);
  const Loop slot = of_part({{-1, 1}, {5, 4}, {4.9, 4.2}, {-1.1, 1.2}}, 5);
  return difference(difference(square(10), hole).at(0), slot).at(0);
}

TEST(Plane, ArcsHaveTheirCornersOnTheCurveAndChordsUpToTheSpacing) {
  for (const auto& [a, b] : {std::pair{2.0, 2.0}, {3.0, 1.0}}) {
    const Point along{0.6, 0.8};
    const auto spacing = [](const Point& p) { return 0.1 + 0.05 * std::abs(p[0]); };
    const Polygon corners = arc({1, -2}, a * along, {-0.8 * b, 0.6 * b}, 4, spacing);
    double longest = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Point from = corners[i] - Point{1, -2};
      const double u = dot(from, along) / a;
      const double v = cross(along, from) / b;
      EXPECT_NEAR(u * u + v * v, 1, 1e-14);
      const Point to = corners[(i + 1) % corners.size()];
      longest = std::max(longest, norm(to - corners[i]) / spacing(corners[i] + 0.5 * (to - corners[i])));
    }
    EXPECT_LE(longest, 1.02) << "in spacings";
    EXPECT_GE(longest, 0.8);
    EXPECT_NEAR(signed_area(corners), std::numbers::pi * a * b, 0.01 * std::numbers::pi * a * b);
  }
  // At least an octagon, for any spacing.
  EXPECT_EQ(arc({0, 0}, {1, 0}, {0, 1}, 4, [](const Point&) { return 100.0; }).size(), 8u);
  EXPECT_EQ(arc({0, 0}, {1, 0}, {0, 1}, 4, [](const Point&) { return 1e-9; }).size(), 8 * max_chords);
  const Polygon half = arc({0, 0}, {1, 0}, {0, 1}, 2, [](const Point&) { return 100.0; });
  EXPECT_THAT(half.front(), ElementsAre(1, 0));
  EXPECT_THAT(half.back(), ElementsAre(-1, 0));
}

TEST(Plane, DifferenceKeepsPartsAndArea) {
  const Shape shape = plate();
  ASSERT_EQ(shape.loops.size(), 2u);
  EXPECT_GT(signed_area(shape.loops[0].corners), 0);
  EXPECT_LT(signed_area(shape.loops[1].corners), 0);
  EXPECT_THAT(shape.loops[1].part, Each(4));
  // The slot's area in the square, by hand: height of a parallelogram times its part right of y = 0.
  const Point along{6, 3};
  const double length = norm(along);
  const double height = cross(along, Point{-0.1, 0.2}) / length;
  EXPECT_EQ(std::ranges::count(shape.loops[0].part, 5), 3);
  EXPECT_EQ(std::ranges::count(shape.loops[0].part, 3), 2) << "the left side is left in two pieces";
  double hole = 0;
  hole = -signed_area(shape.loops[1].corners);
  const double lower_wall = norm({5, 2.5});
  const double upper_wall = norm({4.9, 2.45});
  EXPECT_NEAR(area(shape), 100 - hole - height * (lower_wall + upper_wall) / 2, 1e-12);
  // A band through the middle leaves two pieces, one over everything none.
  EXPECT_EQ(difference(square(10), of_part({{-1, 4}, {11, 4}, {11, 5}, {-1, 5}}, 5)).size(), 2u);
  EXPECT_TRUE(difference(square(10), of_part({{-1, -1}, {11, -1}, {11, 11}, {-1, 11}}, 5)).empty());
  // Corners in the middle of a straight edge are kept.
  Shape divided = square(10);
  divided.loops[0].corners.insert(divided.loops[0].corners.begin() + 1, Point{4, 0});
  divided.loops[0].part = {0, 1, 1, 2, 3};
  const Shape cut = difference(divided, of_part({{2, -1}, {3, -1}, {3, 2}, {2, 2}}, 5)).at(0);
  EXPECT_EQ(std::ranges::count(cut.loops[0].part, 0), 2);
  EXPECT_EQ(std::ranges::count(cut.loops[0].part, 1), 2);
}

TEST(Plane, SidesAreCalledByTheirPartAndTheEndThatTheyLieAt) {
  const Shape shape = plate();
  std::vector<std::string> at_left;
  for (std::size_t i = 0; i < shape.loops[0].size(); ++i)
    for (const std::string& name : names_of_side(shape, 0, i))
      if (names_of_side(shape, 0, i)[0] == "edge-3") at_left.push_back(name);
  EXPECT_THAT(at_left, UnorderedElementsAre("edge-3", "y-min", "edge-3", "y-min"));
  EXPECT_THAT(names_of_side(shape, 1, 0), ElementsAre("hole-0"));
  // The corner of a circle's end: the chords there.
  Shape circle{{of_part(arc({5, 5}, {5, 0}, {0, 5}, 4, [](const Point&) { return 1.0; }), 0)},
               {{"edge-0", true}}};
  int n_top = 0;
  for (std::size_t i = 0; i < circle.loops[0].size(); ++i)
    n_top += std::ranges::count(names_of_side(circle, 0, i), "z-max");
  EXPECT_EQ(n_top, 2);
}

TEST(Plane, FindsTheSmallestGapAndTheSharpestCorner) {
  const Shape shape = plate();
  const auto gap = smallest_gap(shape, 1);
  ASSERT_TRUE(gap);
  EXPECT_NEAR(gap->distance, std::hypot(0.1, 0.2), 1e-12) << "the height of the slot";
  EXPECT_FALSE(smallest_gap(shape, 0.2));
  EXPECT_TRUE(come_near(shape.loops[1].corners, {{10, 0}, {11, 0}, {11, 9}, {10, 9}}, 1.6));
  EXPECT_FALSE(come_near(shape.loops[1].corners, {{10, 0}, {11, 0}, {11, 9}, {10, 9}}, 1.4));
  Shape wedge = square(10);
  wedge.loops[0].corners = {{0, 0}, {10, 0}, {10, 2}};
  wedge.loops[0].part = {0, 1, 2};
  EXPECT_NEAR(sharpest_corner(wedge).angle, std::atan2(2, 10), 1e-12);
  EXPECT_THAT(sharpest_corner(wedge).place, ElementsAre(0, 0));
}

/// True if a point is in the shape, by its winding number.
bool winds(const Shape& shape, const Point& p) {
  double angle = 0;
  for (const Loop& loop : shape.loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Point a = loop.from(i) - p;
      const Point b = loop.to(i) - p;
      angle += std::atan2(cross(a, b), dot(a, b));
    }
  return angle > std::numbers::pi;
}

double nearest(const Shape& shape, const Point& p) {
  double gap = 1e9;
  for (const Loop& loop : shape.loops)
    for (std::size_t i = 0; i < loop.size(); ++i) gap = std::min(gap, distance(p, loop.from(i), loop.to(i)));
  return gap;
}

TEST(Subdivision, PartsThePlateWhereFiguresEndAndMergesWhatNearlyCoincides) {
  const Polygon lower{{2, 2}, {5, 2}, {5, 5}, {2, 5}};
  const Polygon beside{{5 + 1e-8, 3}, {8, 3}, {8, 6}, {5 + 1e-8, 6}};
  const Polygon beyond{{-1, 8}, {11, 8}, {11, 12}, {-1, 12}};
  const Polygon at_edge{{1e-9, 6}, {1, 6}, {1, 8 + 1e-9}, {-1e-9, 8}};
  const Subdivision divided = subdivide(square(10), {lower, beside, beyond, at_edge}, 1e-6);
  const auto line = [&](const Point& from, const Point& to) {
    const auto is_at = [&](int corner, const Point& p) {
      return norm(divided.corners.at(static_cast<std::size_t>(corner)) - p) < 1e-6;
    };
    std::vector<Subdivision::Line> found;
    for (const Subdivision::Line& one : divided.lines)
      if ((is_at(one.end[0], from) && is_at(one.end[1], to)) ||
          (is_at(one.end[0], to) && is_at(one.end[1], from)))
        found.push_back(one);
    EXPECT_EQ(found.size(), 1U);
    return found.at(0);
  };
  // The plate: two sides, one divided at 8, one at 6 and 8. The figures: 5 + 4, 1 + 1, and 2.
  EXPECT_EQ(divided.lines.size(), 7U + 9U + 2U + 2U);
  const auto common = line({5, 3}, {5, 5});
  EXPECT_THAT(std::vector({common.left, common.right}), UnorderedElementsAre(ElementsAre(0), ElementsAre(1)));
  const auto edge = line({0, 8}, {0, 6});
  EXPECT_EQ(edge.side, 3);
  EXPECT_THAT(edge.left, ElementsAre(3));
  EXPECT_EQ(divided.corners[static_cast<std::size_t>(edge.end[0])][0], 0) << "exactly";
  EXPECT_THAT(line({0, 8}, {0, 10}).left, ElementsAre(2));
  EXPECT_EQ(line({0, 0}, {0, 6}).side, 3);
  const auto top = line({0, 8}, {1, 8});
  EXPECT_THAT(std::vector({top.left, top.right}), UnorderedElementsAre(ElementsAre(2), ElementsAre(3)));
}

TEST(SideIndex, FindsWhatASearchOfAllSidesFinds) {
  const Shape shape = plate();
  const SideIndex sides(shape, 1e-11);
  RandomStream stream(1, 0, "places");
  for (int i = 0; i < 5000; ++i) {
    const Point p{stream.uniform(-0.5, 10.5), stream.uniform(-0.5, 10.5)};
    EXPECT_EQ(sides.contains(p), winds(shape, p));
    if (sides.contains(p)) {
      EXPECT_NEAR(sides.distance(p), nearest(shape, p), 1e-12);
    }
  }
  // On sides and corners, within rounding.
  for (const Side& side : sides.sides())
    for (const double share : {0.0, 0.3, 1.0}) {
      const Point p = side.from + share * side.length * side.along;
      EXPECT_TRUE(sides.contains(p));
      int n_sides = 0;
      sides.for_sides_at(p, [&](std::size_t) { ++n_sides; });
      EXPECT_EQ(n_sides, share == 0.3 ? 1 : 2);
    }
}

TEST(SideIndex, CoverAgreesWithPointsInTheHull) {
  const Shape shape = plate();
  const SideIndex sides(shape, 1e-11);
  RandomStream stream(1, 0, "hulls");
  int n_crossing = 0;
  for (int i = 0; i < 3000; ++i) {
    const double size = 0.05 + 3 * stream.uniform() * stream.uniform();
    const Point centre{stream.uniform(0, 10), stream.uniform(0, 10)};
    std::array<Point, 4> corners{};
    for (Point& p : corners) p = centre + Point{size * stream.uniform(-1, 1), size * stream.uniform(-1, 1)};
    int n_inside = 0;
    constexpr int n_points = 300;
    for (int k = 0; k < n_points; ++k) {
      std::array<double, 4> weight{};
      double sum = 0;
      for (double& w : weight) sum += w = -std::log(1 - stream.uniform());
      Point p{};
      for (std::size_t c = 0; c < 4; ++c) p = p + weight[c] / sum * corners[c];
      n_inside += winds(shape, p);
    }
    const Cover cover = sides.cover(corners);
    n_crossing += cover == Cover::crossing;
    if (n_inside > 0 && n_inside < n_points) {
      EXPECT_EQ(cover, Cover::crossing) << i;
    }
    if (cover == Cover::inside) {
      EXPECT_EQ(n_inside, n_points) << i;
    }
    if (cover == Cover::outside) {
      EXPECT_EQ(n_inside, 0) << i;
    }
  }
  std::printf("%d of 3000 hulls reach through the boundary\n", n_crossing);
  EXPECT_GT(n_crossing, 300);
}

TEST(SideIndex, HullsThatTouchOrLieOnASide) {
  const Shape shape = plate();
  const SideIndex sides(shape, 1e-11);
  const auto& all = sides.sides();
  for (const Side& side : all) {
    const Point inward{-side.along[1], side.along[0]};
    const Point middle = side.from + side.length / 2 * side.along;
    const double step = side.length / 50;
    const auto at = [&](double along, double up) {
      return middle + along * step * side.along + up * step * inward;
    };
    EXPECT_EQ(sides.cover({at(-1, 0), at(1, 0), at(0, 1), at(1, 1)}), Cover::inside);
    EXPECT_EQ(sides.cover({at(-1, 0), at(1, 0), at(0, -1), at(1, -1)}), Cover::outside);
    EXPECT_EQ(sides.cover({at(-1, 0), at(1, 0), at(2, 0), at(3, 0)}), Cover::outside) << "flat";
    EXPECT_EQ(sides.cover({at(-1, -0.1), at(1, 0.1), at(0, 1), at(1, 1)}), Cover::crossing);
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::plane
