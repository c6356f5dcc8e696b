// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/index.h"
#include "common/random.h"
#include "geometry/mother_points.h"

#include "geometry/near_pairs.h"
#include "support/geometry_bodies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

namespace crackle::geometry {
namespace CRACKLE_TEST_FILE {

using plane::Face;
using ::testing::AllOf;
using testing::body;
using ::testing::HasSubstr;
using testing::mesh;
using testing::mm;
using testing::notch;
using ::testing::ThrowsMessage;

double squared_distance(const Point& a, const Point& b) {
  return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
}

TEST(SpacingField, GrowsFromTheTip) {
  const Body notched = body({10, 60, 80}, {notch(Face::y_min, 40, 10, 2)});
  const SpacingField spacing(notched, mesh(4, 0.5, 0.1));
  EXPECT_DOUBLE_EQ(spacing({mm, 10 * mm, 40.5 * mm}), 0.5 * mm);
  EXPECT_DOUBLE_EQ(spacing({mm, 15 * mm, 40 * mm}), 1.0 * mm);
  EXPECT_DOUBLE_EQ(spacing({mm, 10 * mm, 61 * mm}), 2.5 * mm);
  EXPECT_DOUBLE_EQ(spacing({mm, 59 * mm, 1 * mm}), 4 * mm);
}

TEST(SpacingField, FollowsTheBodyWhereThatIsFiner) {
  // A thin slot, and two slots 0.4 mm apart.
  const Body thin = body({10, 60, 80}, {notch(Face::y_min, 40, 30, 0.2)});
  EXPECT_LE(SpacingField(thin, mesh(4, 0.5, 0.1))({mm, 1 * mm, 40.1 * mm}), (1 + 1e-12) * 0.2 * mm);
  const Body close = body({10, 60, 80}, {notch(Face::y_min, 40, 30, 3), notch(Face::y_min, 43.4, 30, 3)});
  const SpacingField between(close, mesh(4, 3, 0.1));
  for (const double y : {0.0, 20.0, 30.0})
    for (const double wall : {41.5, 41.9})
      EXPECT_NEAR(between({mm, y * mm, wall * mm}), 0.4 * mm, 1e-15) << y << " " << wall;
  EXPECT_NEAR(between({mm, 20 * mm, 41.7 * mm}), (1 + 0.2 / 2) * 0.4 * mm, 1e-15) << "grown from the walls";
  EXPECT_EQ(SpacingField(body({2, 30, 30}), mesh(9, 9))({mm, mm, mm}), 2 * mm);
}

TEST(SpacingField, IsFineInRegionsAndGrowsFromThem) {
  const Body notched = body({10, 60, 80}, {notch(Face::y_min, 40, 10, 2)});
  input::Mesh parameters = mesh(4, 0.5, 0.1);
  parameters.regions = {testing::region({plane::unbounded, {10, 50}, {30, 50}}, 1),
                        testing::region({plane::unbounded, plane::unbounded, {70, 200}}, 2),
                        testing::region({plane::unbounded, {20, 30}, {70, 80}}, 3)};
  const SpacingField spacing(notched, parameters);
  EXPECT_DOUBLE_EQ(spacing({mm, 10 * mm, 40 * mm}), 0.5 * mm);  // a notch keeps its finer spacing
  EXPECT_DOUBLE_EQ(spacing({mm, 40 * mm, 30 * mm}), 1 * mm);
  EXPECT_DOUBLE_EQ(spacing({mm, 53 * mm, 54 * mm}), 1.5 * mm);
  EXPECT_DOUBLE_EQ(spacing({mm, 25 * mm, 75 * mm}), 2 * mm);  // the finer of the two
  EXPECT_DOUBLE_EQ(spacing({mm, 59 * mm, 65 * mm}), 2.5 * mm);
  EXPECT_DOUBLE_EQ(spacing({mm, 59 * mm, 1 * mm}), 4 * mm);
}

TEST(SpacingField, ChangesNoFasterThanItsLargestGrowth) {
  const Body notched = testing::four_notches();
  const SpacingField spacing(notched, mesh(1.5, 0.2, 0.3));
  RandomStream stream(1, 1, "points");
  const auto point = [&] {
    return Point{stream.uniform(0, 2 * mm), stream.uniform(0, 10 * mm), stream.uniform(0, 12 * mm)};
  };
  EXPECT_DOUBLE_EQ(spacing.largest_growth(), 0.3);
  for (int i = 0; i < 2000; ++i) {
    const Point a = point();
    const Point b = point();
    EXPECT_LE(std::abs(spacing(a) - spacing(b)), 0.3 * std::sqrt(squared_distance(a, b)) * (1 + 1e-12));
    const Box box{{std::min(a[0], b[0]), std::min(a[1], b[1]), std::min(a[2], b[2])},
                  {std::max(a[0], b[0]), std::max(a[1], b[1]), std::max(a[2], b[2])}};
    EXPECT_LE(spacing.lower_bound(box), std::min(spacing(a), spacing(b)));
    EXPECT_GE(spacing.upper_bound(box), std::max(spacing(a), spacing(b)));
  }
}

class Plate : public ::testing::Test {
protected:
  static void SetUpTestSuite() {
    points_ = new MotherPoints(make_mother_points(testing::short_plate(), testing::plate_mesh(), 2012));
  }
  static void TearDownTestSuite() { delete points_; }
  const Body plate = testing::short_plate();
  const MotherPoints& points() const { return *points_; }

private:
  static inline MotherPoints* points_ = nullptr;
};

TEST_F(Plate, PointsLieInTheBodyAndAreClassified) {
  std::array<int, 4> count{};
  for (std::size_t i = 0; i < points().size(); ++i) {
    EXPECT_TRUE(plate.contains(points().position[i]));
    EXPECT_EQ(points().movable[i], plate.movable(points().position[i]));
    ++count[index(std::popcount(points().movable[i]))];
  }
  std::printf("corners %d, edges %d, surfaces %d, interior %d\n", count[0], count[1], count[2], count[3]);
  EXPECT_EQ(count[0], 24);
  EXPECT_GT(count[1], 100);
  EXPECT_GT(count[2], count[1]);
  EXPECT_GT(count[3], 0);
}

TEST_F(Plate, NumberIsTheEstimate) {
  const double estimate = estimate_n_points(plate, testing::plate_mesh());
  std::printf("%zu points, estimate %.0f\n", points().size(), estimate);
  EXPECT_NEAR(estimate / static_cast<double>(points().size()), 1, 0.05);
}

// Two cells over the height of the notch: one point inside each of the two vertical edges of a tip.
TEST_F(Plate, TwoCellsOverTheNotchHeight) {
  for (int i = 0; i < 2; ++i) {
    const testing::SlotFaces slot = testing::slot_faces(plate, i);
    for (const double x : {0.0, plate.size()[0]}) {
      const auto on_edge =
          std::count_if(points().position.begin(), points().position.end(), [&](const Point& p) {
            return p[0] == x && p[1] == slot.tip && slot.lower < p[2] && p[2] < slot.upper;
          });
      EXPECT_EQ(on_edge, 1);
    }
  }
}

TEST(MotherPoints, CellsOverTheNotchHeight) {
  for (const auto& [spacing, cells] : {std::pair{0.9, 1}, std::pair{0.55, 1}, std::pair{0.25, 3}}) {
    const Body notched = body({2, 8, 8}, {notch(Face::y_min, 4, 2, 0.8)});
    const MotherPoints points = make_mother_points(notched, mesh(1, spacing), 1);
    const testing::SlotFaces slot = testing::slot_faces(notched, 0);
    const auto on_edge = std::count_if(points.position.begin(), points.position.end(), [&](const Point& p) {
      return p[0] == 0 && p[1] == slot.tip && slot.lower < p[2] && p[2] < slot.upper;
    });
    EXPECT_EQ(on_edge, cells - 1) << "notch spacing " << spacing;
  }
}

// Blue noise: no two points are close, and none is isolated.
TEST_F(Plate, NearestNeighboursAreOneSpacingAway) {
  std::vector<double> ratio;
  for (std::size_t i = 0; i < points().size(); ++i) {
    double nearest = 1;
    for (std::size_t j = 0; j < points().size(); ++j)
      if (i != j) nearest = std::min(nearest, squared_distance(points().position[i], points().position[j]));
    ratio.push_back(std::sqrt(nearest) / points().spacing[i]);
  }
  std::sort(ratio.begin(), ratio.end());
  std::printf("nearest neighbour / spacing: min %.3f, 1 %% %.3f, median %.3f, 99 %% %.3f, max %.3f\n",
              ratio.front(), ratio[ratio.size() / 100], ratio[ratio.size() / 2],
              ratio[ratio.size() * 99 / 100], ratio.back());
  EXPECT_GT(ratio.front(), 0.4);
  EXPECT_GT(ratio[ratio.size() / 100], 0.6);
  EXPECT_NEAR(ratio[ratio.size() / 2], 0.9, 0.1);
  EXPECT_LT(ratio.back(), 1.3);
}

// Random points that repel each other must not keep the fluctuations of random numbers over long distances.
TEST(MotherPoints, NumberInABallHardlyVaries) {
  const MotherPoints points = make_mother_points(body({5, 5, 5}), mesh(0.4, 0.4), 2012);
  RandomStream stream(1, 1, "balls");
  const double radius = 1 * mm;
  constexpr int n_balls = 400;
  double sum = 0;
  double squares = 0;
  for (int ball = 0; ball < n_balls; ++ball) {
    const auto coordinate = [&] { return stream.uniform(1.5 * mm, 3.5 * mm); };
    const Point centre{coordinate(), coordinate(), coordinate()};
    const auto n = static_cast<double>(std::ranges::count_if(
        points.position, [&](const Point& p) { return squared_distance(p, centre) < radius * radius; }));
    sum += n / n_balls;
    squares += n * n / n_balls;
  }
  const double variance = squares - sum * sum;
  std::printf("%.1f points in a ball, variance %.2f\n", sum, variance);
  EXPECT_LT(variance, 0.15 * sum) << "Poisson's is the mean";
}

TEST(NearPairs, AreThoseOfAllPairsOnce) {
  RandomStream stream(1, 1, "pairs");
  std::vector<Point> points;
  std::vector<double> radius;
  for (int i = 0; i < 600; ++i) {
    points.push_back({stream.uniform(0, 1), stream.uniform(0, 2), stream.uniform(-1, 3)});
    radius.push_back(stream.uniform(0.02, 1) * stream.uniform(0.02, 1));
  }
  constexpr std::size_t n_movable = 500;
  std::vector<std::array<std::size_t, 2>> expected, found;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = 0; j < i && j < n_movable; ++j)
      if (std::sqrt(squared_distance(points[i], points[j])) < (radius[i] + radius[j]) / 2)
        expected.push_back({j, i});
  std::vector<std::int32_t> listed;
  for (const auto& [begin, end] : {std::pair<std::size_t, std::size_t>{0, 130}, {130, 510}, {510, 600}}) {
    const NearPairs pairs = near_pairs(points, radius, n_movable, begin, end);
    listed.insert(listed.end(), pairs.other.begin(), pairs.other.end());
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t k = pairs.first[i - begin]; k < pairs.first[i - begin + 1]; ++k)
        found.push_back({std::min(i, index(pairs.other[k])), std::max(i, index(pairs.other[k]))});
  }
  EXPECT_EQ(near_pairs(points, radius, n_movable, 0, points.size()).other, listed);
  std::ranges::sort(expected);
  std::ranges::sort(found);
  EXPECT_GT(found.size(), 1000u);
  EXPECT_EQ(found, expected);
}

// Slab order: neighbours have nearby numbers, unlike in a random order, where the mean difference is a third
// of all.
TEST_F(Plate, NeighboursHaveCloseNumbers) {
  double sum = 0;
  double pairs = 0;
  for (std::size_t i = 0; i < points().size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (squared_distance(points().position[i], points().position[j]) <
          1.44 * points().spacing[i] * points().spacing[i]) {
        sum += static_cast<double>(i - j);
        ++pairs;
      }
  const double share = sum / pairs / static_cast<double>(points().size());
  std::printf("mean difference of neighbours' numbers: %.4f of all points\n", share);
  EXPECT_LT(share, 0.03);
}

TEST_F(Plate, DependsOnTheSeedOnly) {
  const MotherPoints again = make_mother_points(plate, testing::plate_mesh(), 2012);
  EXPECT_EQ(again.position, points().position);
  EXPECT_EQ(again.spacing, points().spacing);
  EXPECT_EQ(again.movable, points().movable);
  EXPECT_NE(make_mother_points(plate, testing::plate_mesh(), 2013).position, points().position);
}

double nearest_neighbour(const MotherPoints& points, std::size_t i) {
  double nearest = 1;
  for (std::size_t j = 0; j < points.size(); ++j)
    if (i != j) nearest = std::min(nearest, squared_distance(points.position[i], points.position[j]));
  return std::sqrt(nearest);
}

TEST(MotherPoints, KeepTheSpacingOfARegion) {
  const Body plate = testing::short_plate();
  input::Mesh parameters = mesh(1.5, 0.3, 0.2);
  parameters.regions = {testing::region({plane::unbounded, plane::unbounded, {17, 20}}, 0.5)};
  const MotherPoints points = make_mother_points(plate, parameters, 2012);
  EXPECT_NEAR(estimate_n_points(plate, parameters) / static_cast<double>(points.size()), 1, 0.05);
  std::vector<double> inside, beyond;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double z = points.position[i][2] / mm;
    // Here the notches, at 9 and 15 mm, require coarser points.
    if (points.position[i][1] < 6 * mm && z > 17.25 && z < 19.75)
      inside.push_back(nearest_neighbour(points, i));
    if (points.position[i][1] < 6 * mm && z > 21.5 && z < 23)  // 0.8 to 1.1 mm are required
      beyond.push_back(nearest_neighbour(points, i) / points.spacing[i]);
  }
  std::sort(inside.begin(), inside.end());
  std::sort(beyond.begin(), beyond.end());
  ASSERT_GT(inside.size(), 200u);
  ASSERT_GT(beyond.size(), 15u);
  EXPECT_NEAR(inside[inside.size() / 2], 0.45 * mm, 0.05 * mm);
  EXPECT_LT(inside.back(), 0.65 * mm);
  EXPECT_NEAR(beyond[beyond.size() / 2], 0.9, 0.1);
}

TEST(MotherPoints, RefusesMeshesThatAreTooLarge) {
  EXPECT_THAT(
      [] {
        make_mother_points(body({100, 100, 100}), mesh(0.1, 0.1), 1);
      },
      ThrowsMessage<std::runtime_error>(HasSubstr("more than 2e+07 mother points would be needed: the "
                                                  "spacing is 0.1 mm")));
  EXPECT_THAT(
      [] {
        make_mother_points(
            body({10, 60, 80}, {notch(Face::y_min, 40, 30, 2), notch(Face::y_max, 40, 20, 1e-3)}),
            mesh(4, 0.5), 1);
      },
      ThrowsMessage<std::runtime_error>(HasSubstr(
          "the spacing is 0.001 mm at its finest (the height of notch 2) and 4 mm at its coarsest")));
}

TEST(MotherPoints, RefusesAQualityOutOfReach) {
  input::Mesh strict = mesh(1, 1);
  strict.min_quality = 0.9;
  EXPECT_THAT(
      [&] {
        make_mother_points(body({3, 3, 3}), strict, 1);
      },
      ThrowsMessage<std::runtime_error>(AllOf(HasSubstr("min_quality = 0.9"), HasSubstr("near ("))));
}

class PointFile : public ::testing::Test {
protected:
  void SetUp() override {
    file_ = std::filesystem::temp_directory_path() / ("crackle_points_" + std::to_string(::getpid()));
  }
  void TearDown() override { std::filesystem::remove(file_); }
  void write(const std::string& text) { std::ofstream(file_) << text; }
  std::string corners() const { return "0 0 0\n2 0 0\n0 3 0\n2 3 0\n0 0 4\n2 0 4\n0 3 4\n2 3 4\n"; }
  std::filesystem::path file_;
  const Body box = body({2, 3, 4});
};

TEST_F(PointFile, SnapsPointsOntoPlanes) {
  write("# x y z in mm\n\n" + corners() +
        "1.0 1.5 2e0 # interior\n-1e-9 +1.5 2\n\t1\t2.9999999999\t4.0000000001\r\n");
  const std::vector<Point> points = read_points(file_, box);
  ASSERT_EQ(points.size(), 11u);
  EXPECT_EQ(box.movable(points[8]), 7);
  EXPECT_EQ(box.movable(points[9]), 6);
  EXPECT_EQ(box.movable(points[10]), 1);
  EXPECT_EQ(points[10][1], box.size()[1]);
}

TEST_F(PointFile, SnapsOntoWallsOnlyWhereTheyAre) {
  const Body notched = body({2, 3, 4}, {notch(Face::y_min, 2, 1, 0.4)});
  std::string text = corners();
  for (const char* x : {"0", "2"})
    for (const char* y : {"0", "1"})
      for (const char* z : {"1.8", "2.2"}) text += std::string(x) + " " + y + " " + z + "\n";
  write(text + "1 0.5 1.8\n1 1 2\n1 2 1.8\n");
  const std::vector<Point> points = read_points(file_, notched);
  EXPECT_EQ(notched.movable(points[16]), 3);
  EXPECT_EQ(notched.movable(points[17]), 5);
  EXPECT_EQ(notched.movable(points[18]), 7);
}

TEST_F(PointFile, ErrorsNameTheLine) {
  write("0 0 0\n1 2\n1 2 x\n1 2 3 4\n1 1 1\n5 1 1\nnan 1 1\n1 1 1\n");
  EXPECT_THAT([&] { read_points(file_, box); },
              ThrowsMessage<std::runtime_error>(AllOf(
                  HasSubstr(file_.string() + ":2: not a point"), HasSubstr(":3: not a point"),
                  HasSubstr(":4: not a point"), HasSubstr(":6: the point (5, 1, 1) mm lies outside the body"),
                  HasSubstr(":7: not a point"), HasSubstr(":8: the same point as in line 5"))));
  write(corners().substr(6));
  EXPECT_THAT(
      [&] { read_points(file_, box); },
      ThrowsMessage<std::runtime_error>(HasSubstr("the corner (0, 0, 0) mm of the body is not among")));
  write("");
  EXPECT_THAT([&] { read_points(file_, box); }, ThrowsMessage<std::runtime_error>(HasSubstr("corner")));
  EXPECT_THAT([&] { read_points("/nonexistent/cloud.txt", box); },
              ThrowsMessage<std::runtime_error>(HasSubstr("/nonexistent/cloud.txt: cannot be read")));
  write("1\n2\n3\n4\n5\n6\n7\n8\n9\n10\n11\n12\n13\n14\n15\n16\n17\n18\n19\n20\n21\n22\n");
  EXPECT_THAT([&] { read_points(file_, box); },
              ThrowsMessage<std::runtime_error>(HasSubstr("2 more errors")));
}

TEST_F(PointFile, MakesTheBase) {
  const input::Mesh fine = mesh(0.7, 0.7);
  const MotherPoints made = make_mother_points(box, fine, 3);
  std::ofstream stream(file_);
  stream.precision(17);
  for (const Point& p : made.position) stream << p[0] / mm << ' ' << p[1] / mm << ' ' << p[2] / mm << '\n';
  stream.close();
  input::Mesh from_file = fine;
  from_file.points = file_;
  const MotherPoints read = make_mother_points(box, from_file, 3);
  ASSERT_EQ(read.size(), made.size());
  EXPECT_EQ(read.movable, made.movable);
  for (std::size_t i = 0; i < read.size(); ++i)
    EXPECT_LT(squared_distance(read.position[i], made.position[i]), 1e-24);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::geometry
