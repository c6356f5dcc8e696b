// SPDX-License-Identifier: GPL-3.0-or-later
// Speed and energy release rate of cracks in any direction from where they start.
#include "common/index.h"
#include "cracks/crack_history.h"
#include "cracks/crack_speed.h"
#include "cracks/front_trajectory.h"
#include "support/effort.h"
#include "support/flat_cracks.h"
#include "support/made_crack.h"
#include "support/plate_family.h"

#include "input_samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

namespace crackle::cracks {
namespace CRACKLE_TEST_FILE {

using geometry::Point;
using test::direction;

constexpr double mm = 1e-3, us = 1e-6;
constexpr double thickness = 0.4 * mm;
constexpr double step = 0.04 * mm;      // of the squares, at which the energy grows
constexpr double toughness = 150;       // [J/m^2]
constexpr double rayleigh_speed = 900;  // [m/s]

/// A crack as the analysis sees it.
struct Measured {
  double largest;  ///< speed [m/s]
  double largest_ratio;
  CrackHistory history;
  std::vector<double> time;  ///< of its rows [s]
  double length_at(std::size_t row) const { return history.length[row * history.n_starts]; }
  double speed_at(std::size_t row) const { return history.speed[row * history.n_starts]; }
  double release_rate_at(std::size_t row) const { return history.release_rate[row * history.n_starts]; }
};

/// Every tetrahedron of start 0's cracks releases the energy of its facets' area.
Measured measure(const geometry::Body& body, const CrackSurface& surface,
                 const mechanics::TetrahedronField<double>& waves = rayleigh_speed) {
  constexpr int n_rows = 101;
  std::map<std::int64_t, double> energy;
  for (const CrackFacet& facet : surface.facets) energy[facet.tetrahedron] += toughness * facet.area;
  dynamics::SampleResult result;
  for (const auto& [tetrahedron, released] : energy)
    result.breaks.push_back({tetrahedron, 0, 0, 0, released, 0});
  result.phase_start = 0;
  result.counts.dynamic_phases = 1;
  const CrackSpeed speed = max_crack_speed(body, front_trajectories(body, surface, waves));
  Measured found{speed.largest, speed.largest_ratio, {}, {}};
  for (int i = 0; i < n_rows; ++i) {
    dynamics::HistoryRow row;
    row.phase = 1;
    row.energy.time = surface.facets.back().time * i / (n_rows - 1);
    std::int64_t last = -1;
    for (const CrackFacet& facet : surface.facets) {
      if (facet.time <= row.energy.time && facet.tetrahedron != last) ++row.energy.broken;
      last = facet.tetrahedron;
    }
    found.time.push_back(row.energy.time);
    result.history.push_back(row);
  }
  found.history = crack_history(body, surface, result, front_trajectories(body, surface, waves), waves);
  return found;
}

/// A body in which a crack starts, and where.
struct Start {
  std::string name;
  std::unique_ptr<const geometry::Body> body;
  Point tip;
  double along;  ///< direction of the slot [degrees]
};

/// Slots 1 mm high in plates of 100 mm: in two faces, and inside.
std::vector<Start> starts() {
  const auto with = [](plane::Face face) {
    return geometry::make_body({{thickness, 100 * mm, 100 * mm}, {{face, 50 * mm, 30 * mm, 1 * mm}}});
  };
  test::PlateText inner{R"(size = ["0.4 mm", "100 mm", "100 mm"])"};
  inner.notches = {R"(from = ["20 mm", "50 mm"]
to = ["40 mm", "50 mm"]
height = "1 mm")"};
  inner.mesh = R"(spacing = "0.4 mm")";
  inner.section = "50 mm";
  std::vector<Start> all;
  all.push_back({"y-min", with(plane::Face::y_min), {thickness / 2, 30 * mm, 50 * mm}, 0});
  all.push_back({"z-max", with(plane::Face::z_max), {thickness / 2, 50 * mm, 70 * mm}, -90});
  all.push_back({"inner",
                 geometry::make_body(input::parse(inner.text(), "plate.toml").specimen),
                 {thickness / 2, 40 * mm, 50 * mm},
                 0});
  return all;
}

constexpr double angles[] = {0, 15, 30, 45, 60, 70, 80};  // to the slot [degrees]

/// Checks every row whose window lies where the speed is even.
void expect_in(const Measured& found, double from, double to, double speed, double rate = toughness) {
  int n = 0;
  double worst_speed = 0, worst_rate = 0;
  for (std::size_t row = 0; row < found.time.size(); ++row) {
    if (found.length_at(row) < from || found.length_at(row) > to) continue;
    ++n;
    worst_speed = std::max(worst_speed, std::abs(found.speed_at(row) / speed - 1));
    worst_rate = std::max(worst_rate, std::abs(found.release_rate_at(row) / rate - 1));
  }
  std::printf("   %d rows from %.1f to %.1f mm: speed within %.2f %%, rate within %.2f %%\n", n, from / mm,
              to / mm, 100 * worst_speed, 100 * worst_rate);
  EXPECT_GT(n, 5);
  EXPECT_LT(worst_speed, 0.01);
  EXPECT_LT(worst_rate, 0.01);
}

TEST(CrackWays, OfASteadyCrackHaveItsSpeedInAnyDirection) {
  for (const Start& start : starts()) {
    for (const double angle : angles) {
      test::FlatCracks made(thickness, step);
      made.begin(0);
      made.add(start.tip, start.along + angle, 25 * mm, 600, 1 * us);
      const Measured found = measure(*start.body, made.surface());
      std::printf("%s at %g degrees: %.2f of 600 m/s\n", start.name.c_str(), angle, found.largest);
      EXPECT_NEAR(found.largest, 600, 6);
      expect_in(found, 4 * mm, 21 * mm, 600);
      for (std::size_t row = 30; row < 90; row += 10)
        EXPECT_NEAR(found.length_at(row), 600 * (found.time[row] - 1 * us), 0.6 * mm) << row;
    }
  }
}

TEST(CrackWays, FollowTheSpeedOfACrackThatSlowsDown) {
  // 800 m/s over 14 mm, then 300 m/s.
  const auto arrival = [](double place) {
    return std::min(place, 14 * mm) / 800 + std::max(0.0, place - 14 * mm) / 300;
  };
  for (const Start& start : starts()) {
    for (const double angle : angles) {
      test::FlatCracks made(thickness, step);
      made.begin(0);
      made.add(start.tip, start.along + angle, 28 * mm, arrival);
      const Measured found = measure(*start.body, made.surface());
      std::printf("%s at %g degrees: %.2f of 800 m/s\n", start.name.c_str(), angle, found.largest);
      EXPECT_NEAR(found.largest, 800, 8);
      expect_in(found, 4 * mm, 10 * mm, 800);
      expect_in(found, 18 * mm, 24 * mm, 300);
    }
  }
}

TEST(CrackWays, GoAroundKinks) {
  for (const Start& start : starts()) {
    for (const double angle : angles) {
      test::FlatCracks made(thickness, step);
      made.begin(0);
      const double time = made.add(start.tip, start.along, 15 * mm, 500, 0);
      made.add(start.tip + 15 * mm * direction(start.along), start.along + angle, 15 * mm, 500, time);
      const Measured found = measure(*start.body, made.surface());
      std::printf("%s with a kink of %g degrees: %.2f of 500 m/s\n", start.name.c_str(), angle,
                  found.largest);
      EXPECT_NEAR(found.largest, 500, 5);
      expect_in(found, 4 * mm, 9 * mm, 500);
      expect_in(found, 20 * mm, 25 * mm, 500);
    }
  }
}

/// Largest speed of a tip in the history [m/s]; NaN counts as none.
double largest_in(const std::vector<double>& values) {
  double largest = 0;
  for (const double value : values) largest = std::fmax(largest, value);
  return largest;
}

TEST(CrackWays, LeadToTheFarthestBranch) {
  // 15 mm, then branches 30 degrees to both sides; the one nearer to the slot's direction is the slower one.
  const Start start = std::move(starts().front());
  test::FlatCracks made(thickness, step);
  made.begin(0);
  const double time = made.add(start.tip, 60, 15 * mm, 500, 0);
  const Point fork = start.tip + 15 * mm * direction(60);
  made.add(fork, 80, 12 * mm, 500, time);
  made.add(fork, 35, 8 * mm, 1000, time);
  const Measured found = measure(*start.body, made.surface());
  std::printf("branched: %.2f of 500 m/s\n", found.largest);
  EXPECT_NEAR(found.largest, 500, 5);
  EXPECT_NEAR(found.length_at(100), 27 * mm, 0.7 * mm);
}

TEST(CrackWays, StepToBranchesBesideInNoTime) {
  // The crack meets a branch that has grown beside it, and stops.
  const Start start = std::move(starts().front());
  test::FlatCracks made(thickness, step);
  made.begin(0);
  const double time = made.add(start.tip, 0, 15 * mm, 500, 0);
  const Point met = start.tip + 15 * mm * direction(0);
  const double across = 99.5;  // to the line from the tip to the branch's end
  made.add(met, across, 5 * mm, 50000, time);
  made.add(met + 5 * mm * direction(across), 0, 15 * mm, 500, time);
  const Measured found = measure(*start.body, made.surface());
  std::printf("with a step to the side: %.2f of 500 m/s\n", found.largest);
  EXPECT_NEAR(found.largest, 500, 10);
  EXPECT_NEAR(found.length_at(100), 30 * mm, 0.7 * mm);
  EXPECT_GT(measure(*start.body, made.surface(), infinity).largest, 900);
}

TEST(CrackWays, OfBranchesSideBySideAreNoFasterThanTheFasterBranch) {
  // After 10 mm a branch leaves, and runs beside the crack at some distance. Pieces across connect them: the
  // branch that comes there first opens them, and the other one goes on later.
  const Start start = std::move(starts().front());
  struct Case {
    double beside, crack, branch;
    bool is_connected;
  };
  std::vector<Case> cases;
  for (const double beside : test::is_full() ? std::vector{0.06, 0.2, 0.8} : std::vector{0.06, 0.8})
    for (const auto& [crack, branch] :
         {std::pair{500.0, 500.0}, {500.0, 300.0}, {300.0, 500.0}, {450.0, 500.0}})
      for (const bool is_connected : {false, true})
        cases.push_back({beside * mm, crack, branch, is_connected});
  for (const auto& [beside, crack, branch, is_connected] : cases) {
    test::FlatCracks made(thickness, step);
    made.begin(0);
    const double fork = 10 * mm;
    made.add(start.tip, 0, 30 * mm, [=, crack = crack](double place) {
      return std::min(place, fork) / 500 + std::max(0.0, place - fork) / crack;
    });
    const Point leaves = start.tip + fork * direction(0);
    const double time = made.add(leaves, 45, beside * std::numbers::sqrt2, branch, fork / 500);
    made.add(leaves + beside * (direction(0) + direction(90)), 0, 19 * mm - beside, branch, time);
    for (double place = 15 * mm; is_connected && place < 28 * mm; place += 4 * mm) {
      const double lead = std::max(crack, branch);
      made.add(start.tip + place * direction(0), 90, beside, 50000, fork / 500 + (place - fork) / lead);
    }
    const Measured found = measure(*start.body, made.surface());
    const double in_history = largest_in(found.history.speed);
    std::printf("%g mm beside, %g and %g m/s%s: %.2f, in the history %.2f\n", beside / mm, crack, branch,
                is_connected ? ", connected" : "", found.largest, in_history);
    EXPECT_NEAR(found.largest, 500, 10);
    EXPECT_LT(in_history, 525);
  }
}

TEST(CrackWays, OfABranchThatOvertakesAnotherAreNoFasterThanEither) {
  // After 10 mm at 500 m/s one branch runs 8 mm at 600 m/s, then at 200 m/s; the other one, at 400 m/s,
  // passes it. Pieces across connect them when the first of them comes there.
  const Start start = std::move(starts().front());
  const double fork = 10 * mm, length = 19 * mm;
  const auto fast = [=](double place) {
    return fork / 500 + std::min(place, 8 * mm) / 600 + std::max(0.0, place - 8 * mm) / 200;
  };
  const auto steady = [=](double place) { return fork / 500 + place / 400; };
  for (const double beside : {0.06 * mm, 0.2 * mm, 0.5 * mm, 0.8 * mm}) {
    for (const bool is_connected : {false, true}) {
      test::FlatCracks made(thickness, step);
      made.begin(0);
      made.add(start.tip, 0, fork, 500, 0);
      const Point leaves = start.tip + fork * direction(0);
      made.add(leaves, 0, 14.8 * mm, fast);
      made.add(leaves, 90, beside, 50000, fork / 500);
      made.add(leaves + beside * direction(90), 0, length, steady);
      for (double place = 2 * mm; is_connected && place < 14 * mm; place += 1.5 * mm)
        made.add(leaves + place * direction(0), 90, beside, 50000, std::min(fast(place), steady(place)));
      const Measured found = measure(*start.body, made.surface());
      const double in_history = largest_in(found.history.speed);
      std::printf("%g mm beside, overtaking%s: %.2f, in the history %.2f\n", beside / mm,
                  is_connected ? ", connected" : "", found.largest, in_history);
      EXPECT_GT(found.largest, 490);
      EXPECT_LT(found.largest, 612);
      EXPECT_LT(in_history, 630);
    }
  }
}

TEST(CrackWays, OfBranchesThatLeadInTurnAreNoFasterThanTheyAre) {
  // Side by side, each runs 18 mm at 500 m/s and waits, in turn; pieces across connect them.
  const Start start = std::move(starts().front());
  const auto waits_after = [](double first) {
    return [=](double place) {
      return place / 500 + 25 * us * std::ceil(std::max(0.0, place - first) / (18 * mm));
    };
  };
  const auto one = waits_after(9 * mm), other = waits_after(18 * mm);
  for (const double beside : {0.2 * mm, 0.5 * mm, 1 * mm}) {
    test::FlatCracks made(thickness, step);
    made.begin(0);
    made.add(start.tip, 0, 45 * mm, one);
    made.add(start.tip + beside * direction(90), 0, 45 * mm, other);
    for (double place = 0; place < 45 * mm; place += 1.5 * mm)
      made.add(start.tip + place * direction(0), 90, beside, 50000, std::min(one(place), other(place)));
    const Measured found = measure(*start.body, made.surface());
    std::printf("%g mm beside, in turn: %.2f of 500 m/s, in the history %.2f\n", beside / mm, found.largest,
                largest_in(found.history.speed));
    EXPECT_FALSE(found.largest > 510) << "there may be none where pieces between two branches are short";
    EXPECT_LT(largest_in(found.history.speed), 525);
  }
}

TEST(CrackWays, OfACrackThatPausesAreThoseWhileItRuns) {
  for (const Start& start : starts()) {
    test::FlatCracks made(thickness, step);
    made.begin(0);
    made.add(start.tip, start.along + 30, 32 * mm,
             [](double place) { return place / 500 + (place > 16 * mm ? 30 * us : 0); });
    const Measured found = measure(*start.body, made.surface());
    std::printf("%s, with a pause: %.2f of 500 m/s\n", start.name.c_str(), found.largest);
    EXPECT_NEAR(found.largest, 500, 5);
    expect_in(found, 4 * mm, 12 * mm, 500);
    expect_in(found, 20 * mm, 28 * mm, 500);
  }
}

TEST(CrackWays, OfABreakAheadOfTheFrontDoNotCount) {
  // A crack starts ahead when the front is a distance from it, and grows to both sides.
  const Start start = std::move(starts().front());
  const double nucleus = 16 * mm;
  for (const double ahead : {0.2 * mm, 0.4 * mm, 0.8 * mm, 1.5 * mm, 3 * mm}) {
    test::FlatCracks made(thickness, step);
    made.begin(0);
    made.add(start.tip, 0, 36 * mm, [=](double place) {
      return std::min(place, nucleus - ahead + std::abs(place - nucleus)) / 500;
    });
    const Measured found = measure(*start.body, made.surface());
    const double in_history = largest_in(found.history.speed);
    std::printf("%g mm ahead: %.2f of 500 m/s, in the history %.2f\n", ahead / mm, found.largest, in_history);
    // Within its reach it is the front's own.
    const double tolerance = ahead < front_reach * made.spacing() ? 25 : 5;
    EXPECT_NEAR(found.largest, 500, tolerance);
    EXPECT_LT(in_history, 530);
  }
}

/// Checks a crack at 500 m/s that meets another, from 13.5 or 20 mm on, which has opened before it comes.
void expect_no_jump(const char* what, const test::FlatCracks::Arrival& arrival, double until, double behind) {
  for (const Start& start : starts()) {
    for (const double angle : {0.0, 45.0, 70.0}) {
      test::FlatCracks made(thickness, step);
      made.begin(0);
      made.add(start.tip, start.along + angle, 36 * mm, arrival);
      const Measured found = measure(*start.body, made.surface());
      const double largest = largest_in(found.history.speed);
      std::printf("%s at %g degrees, %s: %.2f of 500 m/s, in the history %.2f\n", start.name.c_str(), angle,
                  what, found.largest, largest);
      EXPECT_NEAR(found.largest, 500, 10);
      EXPECT_LT(largest, 550);
      for (std::size_t row = 0; row < found.time.size(); ++row) {
        EXPECT_TRUE(found.length_at(row) < until + 0.6 * mm || found.length_at(row) > behind) << row;
        // Within the front_reach it meets the other one.
        if (found.time[row] < (until - 1 * mm) / 500) {
          EXPECT_NEAR(found.length_at(row), 500 * found.time[row], 0.6 * mm) << row;
        }
      }
    }
  }
}

TEST(CrackWays, DoNotJumpToAnotherCrackThatRunsTowardsTheFront) {
  // It starts at 22 mm after 10 us, in both directions.
  expect_no_jump(
      "another crack ahead",
      [](double place) {
        return place < 13.5 * mm ? place / 500 : 10 * us + std::abs(place - 22 * mm) / 500;
      },
      13.5 * mm, 29.5 * mm);
}

TEST(CrackWays, DoNotJumpToWhatOpensAtOnceAheadOfTheFront) {
  expect_no_jump(
      "6 mm at once",
      [](double place) {
        if (place > 20 * mm && place < 26 * mm) return 30 * us;
        return (place < 23 * mm ? place : place - 6 * mm) / 500;
      },
      20 * mm, 25.5 * mm);
}

TEST(CrackWays, DoNotCountWhatIsFasterThanARayleighWave) {
  // A burst of 4 or 6 mm, as where the path passes between branches that have grown side by side.
  for (const Start& start : starts())
    for (const double burst : {4 * mm, 6 * mm}) {
      const auto arrival = [=](double place) {
        return (place - 0.9 * std::clamp(place - 20 * mm, 0.0, burst)) / 500;
      };
      test::FlatCracks made(thickness, step);
      made.begin(0);
      made.add(start.tip, start.along + 45, 36 * mm, arrival);
      const Measured found = measure(*start.body, made.surface());
      const double in_history = largest_in(found.history.speed);
      std::printf("%s, a burst of %g mm: %.2f of 500 m/s, in the history %.2f\n", start.name.c_str(),
                  burst / mm, found.largest, in_history);
      EXPECT_NEAR(found.largest, 500, 10);
      EXPECT_LT(in_history, 525);
      EXPECT_GT(measure(*start.body, made.surface(), 1e4).largest, 900) << "it would count";
    }
}

TEST(CrackWays, CompareSpeedsWithTheMaterialInWhichTheCrackRuns) {
  // 500 m/s where Rayleigh waves have 1,000, 1,500 m/s where they have 3,000, 800 m/s where they have 1,000.
  const Start start = std::move(starts().front());
  test::FlatCracks made(thickness, step);
  made.begin(0);
  double time = made.add(start.tip, 0, 15 * mm, 500, 0);
  time = made.add(start.tip + 15 * mm * direction(0), 0, 15 * mm, 1500, time);
  made.add(start.tip + 30 * mm * direction(0), 0, 15 * mm, 800, time);
  const CrackSurface surface = made.surface();
  const auto along = [&](const CrackFacet& facet) { return facet.corner[0][1] - start.tip[1]; };
  const auto is_stiff = [&](const CrackFacet& facet) {
    return along(facet) > 15 * mm && along(facet) < 30 * mm;
  };
  std::vector<double> waves(surface.facets.size());
  for (const CrackFacet& facet : surface.facets)
    waves[index(facet.tetrahedron)] = is_stiff(facet) ? 3000 : 1000;
  const Measured found = measure(*start.body, surface, mechanics::TetrahedronField<double>(waves));
  std::printf("largest %.2f m/s, largest ratio %.4f, mean Rayleigh speed %.2f m/s\n", found.largest,
              found.largest_ratio, found.history.rayleigh_speed);
  EXPECT_NEAR(found.largest, 1500, 15);
  EXPECT_NEAR(found.largest_ratio, 0.8, 0.02);
  EXPECT_NEAR(found.history.rayleigh_speed, 3 / (2 / 1000.0 + 1 / 3000.0), 5);
  for (std::size_t row = 0; row < found.time.size(); ++row) {
    const double length = found.length_at(row);
    const bool is_even = (length > 4 * mm && length < 11 * mm) || (length > 19 * mm && length < 26 * mm);
    if (is_even) {
      EXPECT_NEAR(found.history.speed_ratio[row * found.history.n_starts], 0.5, 0.01) << row;
    }
  }
  EXPECT_NEAR(measure(*start.body, surface).largest_ratio, 800 / rayleigh_speed, 0.01)
      << "without the stiff part, which is passed faster than its waves";
}

TEST(CrackWays, AreTheSameInARoughCrackOfTetrahedra) {
  for (const double spacing : {0.4, 0.6}) {
    if (spacing < 0.6 && !test::is_full()) continue;
    for (const double angle : angles) {
      const double c = std::cos(angle * std::numbers::pi / 180), s = std::sin(angle * std::numbers::pi / 180);
      const double end = std::min(18.0, 40 * c) * s / c;
      const test::MadeCrack crack(
          spacing, 2.5, 1, [=](double advance) { return advance * s / c; }, 0, end);
      const CrackSurface surface = crack.surface([&](const test::MadeCrack::Tetrahedron& t, RandomStream&) {
        const double place = t.advance / c + t.side * s;  // along the crack
        return place > 0 && place < std::min(18 / c, 40.0) ? place / 500 : -1;
      });
      const double length = 500 * surface.facets.back().time / crack.mm();
      const double mean_rate = toughness * surface.area() / (length * crack.body().size()[0]);
      const Measured found = measure(crack.body(), surface, rayleigh_speed / crack.mm());
      double speed = 0, rate = 0, n = 0;
      for (std::size_t row = 25; row < 80; ++row, ++n) {
        speed += found.speed_at(row);
        rate += found.release_rate_at(row);
      }
      speed *= crack.mm() / n;
      std::printf("%g mm, %g degrees: largest %.2f, mean %.2f of 500 m/s, rate %.4f of the mean\n", spacing,
                  angle, found.largest * crack.mm(), speed, rate / n / mean_rate);
      EXPECT_NEAR(found.largest * crack.mm(), 500, 5);
      EXPECT_NEAR(speed, 500, 5);
      EXPECT_NEAR(rate / n / mean_rate, 1, 0.02);
    }
  }
}

TEST(CrackWays, ACrackTooShortForAWayHasALengthAndNoSpeed) {
  const Start start = std::move(starts().front());
  test::FlatCracks made(thickness, step);
  made.begin(0);
  made.add(start.tip, 60, 2 * made.spacing(), 500, 0);
  const Measured found = measure(*start.body, made.surface());
  EXPECT_TRUE(std::isnan(found.largest));
  // Along the slot, cos 60 degrees of it.
  EXPECT_NEAR(found.length_at(100), 2 * made.spacing() * 0.5, made.spacing() / 2);
  EXPECT_GT(found.length_at(100), 0);
  EXPECT_GT(found.history.area.back(), 0);
  EXPECT_TRUE(std::isnan(found.speed_at(50)));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::cracks
