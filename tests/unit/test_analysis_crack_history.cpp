// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/real.h"
#include "cracks/crack_history.h"
#include "cracks/front_trajectory.h"

#include "support/structured_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <vector>

namespace crackle::cracks {
namespace CRACKLE_TEST_FILE {

using geometry::Point;
using test::StructuredMesh;

constexpr double thickness = 4, energy = 0.3;  // of each tetrahedron [J]

TEST(CracksInSpace, ReachAsFarAsTheyAreOpenAndRunAtTheirSpeed) {
  constexpr double speed = 400, spacing = 0.1;
  CrackSurface surface;
  surface.cracks.resize(2);
  const auto open = [&](const Point& at, double time, std::int32_t crack) {
    CrackFacet facet{};
    const Vector x{spacing / 2, 0, 0}, y{0, spacing / 2, 0};
    facet.corner = {{at - x, at + y, at + x, at - y}};
    facet.area = spacing * spacing;
    facet.time = time;
    facet.crack = crack;
    surface.facets.push_back(facet);
  };
  // A disk that grows from its centre, and a facet elsewhere that opens at once.
  open({9, 9, 9}, 0, 1);
  for (double r = 0; r < 2; r += spacing)
    for (int k = 0; k < 8; ++k) open({r * std::cos(0.7 * k), r * std::sin(0.7 * k), 0}, r / speed, 0);
  std::vector<std::size_t> n_open;
  std::vector<double> times;
  for (int i = 0; i < 10; ++i) {
    times.push_back((2 * spacing * i + spacing / 2) / speed);
    n_open.push_back(0);
    for (const CrackFacet& facet : surface.facets) n_open.back() += facet.time <= times.back() ? 1 : 0;
  }
  const auto found = cracks_in_space(surface, n_open, times, 2 * speed);
  ASSERT_EQ(found.speed.size(), 20U);
  EXPECT_TRUE(std::isnan(cracks_in_space(surface, n_open, times, speed / 2).speed[10]));
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(found.reach[2 * i], 2 * spacing * static_cast<double>(i), 1e-12);
    EXPECT_NEAR(found.area[2 * i], 8 * (2 * static_cast<double>(i) + 1) * spacing * spacing, 1e-12);
    EXPECT_NEAR(found.speed[2 * i], speed, 1e-6);
    EXPECT_EQ(found.reach[2 * i + 1], 0);
    EXPECT_TRUE(std::isnan(found.speed[2 * i + 1]));
  }
}

/// A plate 40 wide with a notch 4 deep at each side, and cracks from these.
class Histories : public testing::Test {
protected:
  CrackHistory history(const std::function<double(const Point&)>& time, double last,
                       std::int32_t n_phases = 1) {
    result.breaks = mesh.break_between([](const Point& p) { return p[2] > 8.5 ? 1 : 0; }, time);
    for (auto& broken : result.breaks) broken.released_energy = energy;
    result.phase_start = 0;
    result.counts.dynamic_phases = n_phases;
    for (int i = 0; i <= 20; ++i) {
      dynamics::HistoryRow row;
      row.phase = n_phases;
      row.load_time = row.energy.time = last * i / 20;
      for (const auto& broken : result.breaks)
        row.energy.broken += broken.load_time + broken.phase_time <= row.load_time;
      result.history.push_back(row);
    }
    surface = make_crack_surface(mesh.body(), mesh.realization(), result.breaks, 0);
    return crack_history(mesh.body(), surface, result, front_trajectories(mesh.body(), surface, infinity),
                         infinity);
  }

  StructuredMesh mesh{
      {{thickness, 40, 36}, {{plane::Face::y_min, 8.5, 4, 1}, {plane::Face::y_max, 27.5, 4, 1}}}};
  dynamics::SampleResult result;
  CrackSurface surface;
};

TEST_F(Histories, OfASteadyCrackGrowLinearlyAtItsSpeedAndToughness) {
  const double speed = 500;
  const auto found =
      history([&](const Point& p) { return p[1] > 4 && p[1] < 34 ? (p[1] - 4) / speed : -1; }, 0.06);
  ASSERT_EQ(found.n_starts, 2U);
  ASSERT_EQ(found.length.size(), 42U);
  const double released = energy * static_cast<double>(result.breaks.size());
  for (std::size_t i = 2; i < 19; ++i) {
    const double time = result.history[i].energy.time;
    std::printf("%5.1f ms: length %.2f of %.2f m, %.1f m/s, %.3f J/m^2\n", 1e3 * time, found.length[2 * i],
                speed * time, found.speed[2 * i], found.release_rate[2 * i]);
    EXPECT_NEAR(found.length[2 * i], speed * time, 1.2);
    EXPECT_NEAR(found.speed[2 * i], speed, 0.1 * speed);
    // At the first and last spacings of the crack the window is truncated.
    if (i > 4 && i < 17) {
      EXPECT_NEAR(found.release_rate[2 * i], released / (30 * thickness), 0.12 * released / (30 * thickness));
    }
    EXPECT_EQ(found.length[2 * i + 1], 0);
    EXPECT_EQ(found.area[2 * i + 1], 0);
    EXPECT_TRUE(std::isnan(found.speed[2 * i + 1]));
    EXPECT_GE(found.area[2 * i], found.area[2 * i - 2]);
  }
  EXPECT_EQ(found.area[40], surface.area());
}

TEST_F(Histories, FollowTheSpeedOfATipThatSlowsDown) {
  // 600 m/s over the first half of the ligament, 200 m/s over the second.
  const auto arrival = [](double y) { return y < 19 ? (y - 4) / 600 : 15.0 / 600 + (y - 19) / 200; };
  const auto found = history([&](const Point& p) { return p[1] > 4 && p[1] < 34 ? arrival(p[1]) : -1; }, 0.1);
  const auto speed_at = [&](double time) {
    return found.speed[2 * static_cast<std::size_t>(std::lround(time / 0.005))];
  };
  std::printf("%.0f m/s where it is 600, %.0f m/s where it is 200\n", speed_at(0.015), speed_at(0.065));
  EXPECT_NEAR(speed_at(0.015), 600, 60);
  EXPECT_NEAR(speed_at(0.065), 200, 20);
}

TEST_F(Histories, OfAnEarlierPhaseHaveLengthButNoSpeed) {
  auto found = history([&](const Point& p) { return p[1] > 4 && p[1] < 34 ? (p[1] - 4) / 500 : -1; }, 0.06);
  for (auto& row : result.history) row.phase = 0;
  found = crack_history(mesh.body(), surface, result, front_trajectories(mesh.body(), surface, infinity),
                        infinity);
  EXPECT_GT(found.length[30], 10);
  for (const double speed : found.speed) EXPECT_TRUE(std::isnan(speed));
}

TEST_F(Histories, OfABodyThatNeverRanGrowWithTheLoad) {
  history([&](const Point& p) { return p[1] > 4 && p[1] < 34 ? (p[1] - 4) / 500 : -1; }, 0.06);
  for (auto& broken : result.breaks) {
    broken.load_time += broken.phase_time;
    broken.phase_time = 0;
  }
  for (auto& row : result.history) row.phase = 0;
  result.phase_start = dynamics::SampleResult::none;
  result.counts.dynamic_phases = 0;
  surface = make_crack_surface(mesh.body(), mesh.realization(), result.breaks, result.phase_start);
  const auto found = crack_history(mesh.body(), surface, result,
                                   front_trajectories(mesh.body(), surface, infinity), infinity);
  for (std::size_t i = 2; i < 19; ++i)
    EXPECT_NEAR(found.length[2 * i], 500 * result.history[i].load_time, 1.2) << i;
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::cracks
