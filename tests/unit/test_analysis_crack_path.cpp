// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/real.h"
#include "cracks/crack_pattern.h"
#include "cracks/crack_speed.h"
#include "cracks/front_trajectory.h"
#include "cracks/section_crossings.h"

#include "support/effort.h"
#include "support/made_crack.h"
#include "support/structured_mesh.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace crackle::cracks {
namespace CRACKLE_TEST_FILE {

using geometry::Point;
using test::StructuredMesh;

// Positions in the notched plate [m]: notch 0 has its tip at y = 4 and its plane at z = 8.5, notch 1 its tip
// at y = 12 and its plane at z = 15.5; each ligament is 12 long, the plate 4 thick.
constexpr double plane_0 = 8.5;
constexpr double plane_1 = 15.5;

const auto at_once = [](const Point&) { return 0.0; };

class CrackPath : public testing::Test {
protected:
  CrackSurface surface(const std::function<int(const Point&)>& label,
                       const std::function<double(const Point&)>& time = at_once) const {
    return make_crack_surface(mesh.body(), mesh.realization(), mesh.break_between(label, time), 0);
  }
  /// The crack in the plane of notch 0 up to y = end.
  CrackSurface straight(double end) const {
    return surface([](const Point& p) { return p[2] > plane_0 ? 1 : 0; },
                   [end](const Point& p) { return p[1] > 4 && p[1] < end ? 0.0 : -1.0; });
  }
  /// Cracks in the planes of both notches up to these y.
  CrackSurface two_cracks(double end_0, double end_1) const {
    return surface([](const Point& p) { return p[2] > plane_1   ? 2
                                               : p[2] > plane_0 ? 1
                                                                : 0; },
                   [=](const Point& p) {
                     const bool first = p[2] < 12 && p[1] > 4 && p[1] < end_0;
                     const bool second = p[2] > 12 && p[1] < 12 && p[1] > end_1;
                     return first || second ? 0.0 : -1.0;
                   });
  }
  SectionCrossing crossing(const CrackSurface& cracks, int notch, double y) const {
    return section_crossings(mesh.body(), cracks, find_branches(mesh.body(), cracks),
                             planes_of({.y = {y}, .z = {}}))
        .at(static_cast<std::size_t>(notch));
  }

  StructuredMesh mesh{test::notched_plate()};
};

TEST_F(CrackPath, CrossingsOfAPlaneCrackLieOnItsPlane) {
  const CrackSurface cracks = straight(10);
  const std::vector<double> sections{3.5, 4.5, 6.5, 9.5, 10.5};
  const auto crossings = section_crossings(mesh.body(), cracks, find_branches(mesh.body(), cracks),
                                           planes_of({.y = sections, .z = {}}));
  ASSERT_EQ(crossings.size(), 10u);
  for (std::size_t s = 0; s < sections.size(); ++s) {
    std::printf("y = %g: z = %.15g, branches %zu\n", sections[s], crossings[s].position,
                crossings[s].branches.size());
  }
  for (const std::size_t s : {1u, 2u, 3u}) {
    EXPECT_NEAR(crossings[s].position, plane_0, 1e-12);
    EXPECT_EQ(crossings[s].branches.size(), 1U);
  }
  for (const std::size_t s : {0u, 4u, 5u, 6u, 7u, 8u, 9u}) {  // in the notch, ahead of the crack, notch 1
    EXPECT_TRUE(std::isnan(crossings[s].position));
    EXPECT_EQ(crossings[s].branches.size(), 0U);
  }
}

TEST_F(CrackPath, TheCrackThatCrossesMostOfItsLigamentLeads) {
  EXPECT_EQ(leading_start(mesh.body(), two_cracks(14, 6)), 0);
  EXPECT_EQ(leading_start(mesh.body(), two_cracks(10, 2)), 1);
  EXPECT_EQ(leading_start(mesh.body(), straight(10)), 0);
  EXPECT_EQ(leading_start(mesh.body(), CrackSurface{}), -1);
  EXPECT_EQ(leading_start(mesh.body(), straight(4.9)), -1) << "less than started_share";
  EXPECT_EQ(leading_start(mesh.body(), two_cracks(16, 0)), 0) << "of equals at the same time the first";
}

TEST_F(CrackPath, OfEqualsTheOneThatGetsThereFirstLeads) {
  // Both cross the whole ligament; the one of notch 1 starts later and is faster.
  for (const double speed : {1.0, 4.0}) {
    const CrackSurface cracks =
        surface([](const Point& p) { return p[2] > plane_1   ? 2
                                            : p[2] > plane_0 ? 1
                                                             : 0; },
                [speed](const Point& p) {
                  if (p[2] < 12) return p[1] > 4 ? p[1] - 4 : -1.0;
                  return p[1] < 12 ? 3 + (12 - p[1]) / speed : -1.0;
                });
    EXPECT_EQ(crossed_shares(mesh.body(), cracks)[0], crossed_shares(mesh.body(), cracks)[1]);
    EXPECT_EQ(leading_start(mesh.body(), cracks), speed > 2 ? 1 : 0);
  }
}

TEST_F(CrackPath, CrossingsFollowASkewedCrack) {
  // An affine map maps sections to sections and means to means: z = 8.5 + 0.3 y at x = 2, and the slope over
  // the thickness cancels in the mean.
  mesh.map_nodes([](const Point& p) { return Point{p[0], p[1], p[2] + 0.3 * p[1] + 0.2 * (p[0] - 2)}; });
  const CrackSurface cracks = straight(16);
  for (const double y : {4.5, 8.5, 12.5, 15.5}) {
    const SectionCrossing found = crossing(cracks, 0, y);
    std::printf("y = %g: z = %.15g, expected %.15g\n", y, found.position, plane_0 + 0.3 * y);
    EXPECT_NEAR(found.position, plane_0 + 0.3 * y, 1e-12);
    EXPECT_EQ(found.branches.size(), 1U);
    // 0.2 (x - 2) over x = 0..4, in addition to the roughness of the cubes.
    EXPECT_GT(found.spread, 0.8 / std::sqrt(12.0) - 1e-12);
    EXPECT_LT(found.spread, 0.8 / std::sqrt(12.0) + 0.05);
  }
}

TEST_F(CrackPath, MeanAndSpreadOfPlaneFacetsAreExact) {
  // One facet through the whole thickness that rises by 0.8 m: uniform between 8 and 8.8.
  CrackSurface cracks;
  cracks.cracks.push_back({0, 1, 0, 0});
  cracks.facets.push_back({{Point{0, 6, 8}, {4, 6, 8.8}, {4, 7, 8.8}, {0, 7, 8}}, 4, 0, 0, 0});
  SectionCrossing found = crossing(cracks, 0, 6.5);
  std::printf("slanted: z = %.15g, spread %.15g\n", found.position, found.spread);
  EXPECT_NEAR(found.position, 8.4, 1e-12);
  EXPECT_NEAR(found.spread, 0.8 / std::sqrt(12.0), 1e-12);
  // A horizontal one over its half x < 2, at 9: there the mean of both goes from 8.5 to 8.7, elsewhere from
  // 8.4 to 8.8.
  cracks.facets.push_back({{Point{0, 6, 9}, {2, 6, 9}, {2, 7, 9}, {0, 7, 9}}, 2, 0, 0, 0});
  found = crossing(cracks, 0, 6.5);
  std::printf("two over each other: z = %.15g, spread %.15g\n", found.position, found.spread);
  EXPECT_NEAR(found.position, 8.6, 1e-12);
  EXPECT_NEAR(found.spread, std::sqrt((0.2 * 0.2 + 0.4 * 0.4) / 24), 1e-12);
}

TEST_F(CrackPath, TheMeanIsTakenOverTheThicknessCovered) {
  // A step at mid-thickness (z = 8.5 and 9.5, joined by a wall along y) is one crossing; its mean lies
  // between, and does not change when one half is remeshed with the same coverage.
  const CrackSurface cracks = surface([](const Point& p) { return p[2] > (p[0] < 2.5 ? 8.5 : 9.5) ? 1 : 0; },
                                      [](const Point& p) { return p[1] > 4 ? 0.0 : -1.0; });
  const SectionCrossing found = crossing(cracks, 0, 8.5);
  std::printf("step: z = %.15g, branches %zu\n", found.position, found.branches.size());
  EXPECT_NEAR(found.position, 8.5 * 0.625 + 9.5 * 0.375, 0.1);
  EXPECT_EQ(found.branches.size(), 1U);
}

TEST_F(CrackPath, ACrackOverASmallPartOfTheThicknessHasNotArrived) {
  // Full thickness up to y = 8, then only the part x < 1 or x < 2 of the thickness of four.
  for (const double width : {1.0, 2.0}) {
    const CrackSurface cracks =
        surface([](const Point& p) { return p[2] > plane_0 ? 1 : 0; },
                [width](const Point& p) { return p[1] > 4 && (p[1] < 8 || p[0] < width) ? 0.0 : -1.0; });
    EXPECT_NEAR(crossing(cracks, 0, 6.5).position, plane_0, 1e-12);
    const SectionCrossing found = crossing(cracks, 0, 10.5);
    std::printf("covering %g of 4: z = %g\n", width, found.position);
    EXPECT_EQ(std::isnan(found.position), width < min_thickness_share * 4);
    EXPECT_EQ(found.branches.size(), width < min_thickness_share * 4 ? 0 : 1);
  }
}

TEST_F(CrackPath, AHoleInTheCrackIsNoBranch) {
  const CrackSurface cracks =
      surface([](const Point& p) { return p[2] > plane_0 ? 1 : 0; },
              [](const Point& p) { return p[1] > 4 && std::abs(p[0] - 2) > 0.5 ? 0.0 : -1.0; });
  const SectionCrossing found = crossing(cracks, 0, 8.5);
  EXPECT_NEAR(found.position, plane_0, 0.1);
  EXPECT_EQ(found.branches.size(), 1U);
}

TEST_F(CrackPath, StrayBreaksBesideTheCrackDoNotCount) {
  const auto breaks_of = [&](bool with_stray) {
    auto breaks = mesh.break_between([](const Point& p) { return p[2] > plane_0 ? 1 : 0; },
                                     [](const Point& p) { return p[1] > 4 ? 0.0 : -1.0; });
    if (with_stray) {
      // A chain of single cubes away from the crack, at x = 1.
      const auto stray = mesh.break_between(
          [](const Point& p) { return p[0] > 0.5 && p[0] < 1.5 ? 1 : 0; },
          [](const Point& p) {
            return p[0] < 1 && std::abs(p[1] - 8.5) < 0.5 && p[2] > 9 && p[2] < 14 ? 1.0 : -1.0;
          });
      EXPECT_GT(stray.size(), 0u);
      breaks.insert(breaks.end(), stray.begin(), stray.end());
    }
    return breaks;
  };
  const double y = 8.5;
  const CrackSurface clean = make_crack_surface(mesh.body(), mesh.realization(), breaks_of(false), 0);
  const CrackSurface with_stray = make_crack_surface(mesh.body(), mesh.realization(), breaks_of(true), 0);
  ASSERT_EQ(with_stray.cracks.size(), 1u);  // the chain is part of the crack of notch 0
  ASSERT_EQ(with_stray.cracks[0].start, 0);
  const SectionCrossing found = crossing(with_stray, 0, y);
  std::printf("with stray breaks: z = %g, branches %zu\n", found.position, found.branches.size());
  EXPECT_NEAR(found.position, plane_0, 0.35);
  EXPECT_EQ(found.branches.size(), 1U);
  EXPECT_EQ(find_branches(mesh.body(), with_stray).n_in_space(), 0);
  EXPECT_EQ(classify(mesh.body(), with_stray), classify(mesh.body(), clean));
}

TEST_F(CrackPath, OfTwoBranchesTheOneThatCoversMoreIsTheMainCrossing) {
  // Branching at y = 6: the upper branch at z = 13.5 lacks the part x > 3.
  const CrackSurface cracks = surface(
      [](const Point& p) { return p[2] > (p[1] > 6.5 ? 13.5 : plane_0) ? 2
                                  : p[2] > plane_0                     ? 1
                                                                       : 0; },
      [](const Point& p) {
        return p[1] > 4 && !(p[2] > 10 && p[1] > 8 && p[0] > 3) ? (p[2] > 10 ? 0.0 : 1.0) : -1.0;
      });
  const SectionCrossing found = crossing(cracks, 0, 10.5);
  std::printf("branching: z = %g, branches %zu\n", found.position, found.branches.size());
  EXPECT_EQ(found.branches.size(), 2U);
  EXPECT_NEAR(found.position, plane_0, 1e-12);
}

TEST_F(CrackPath, OfEqualCrossingsOfOneArmTheEarlierIsTheMainCrossing) {
  for (const bool upper_first : {false, true}) {
    const CrackSurface cracks = surface(
        [&](const Point& p) { return p[2] > (p[1] > 6.5 ? 13.5 : plane_0) ? 2
                                     : p[2] > plane_0                     ? 1
                                                                          : 0; },
        [=](const Point& p) { return p[1] > 4 ? ((p[2] > 10) == upper_first ? 0.0 : 1.0) : -1.0; });
    const CrackBranches one{{}, std::vector<std::int32_t>(cracks.facets.size(), 0)};
    const SectionCrossing found =
        section_crossings(mesh.body(), cracks, one, planes_of({.y = {12.5}, .z = {}})).at(0);
    EXPECT_EQ(found.branches.size(), 2U);
    EXPECT_NEAR(found.position, upper_first ? 13.5 : plane_0, 1e-12);
  }
}

TEST_F(CrackPath, CrossesAtTheMainArmWhereArmsLieOverEachOther) {
  // From y = 6.5 on a second branch runs at z = 13.5; the first one ends at y = 13.
  const CrackSurface cracks = surface(
      [&](const Point& p) { return p[2] > (p[1] > 6.5 ? 13.5 : plane_0) ? 2
                                   : p[2] > plane_0                     ? 1
                                                                        : 0; },
      [](const Point& p) { return p[1] > 4 && (p[2] > 12 || p[1] < 13) ? 0.0 : -1.0; });
  const CrackBranches branches = find_branches(mesh.body(), cracks);
  ASSERT_EQ(branches.points.size(), 1U);
  EXPECT_TRUE(branches.points[0].is_in_projection && branches.points[0].is_in_space);
  EXPECT_NEAR(branches.points[0].y, 7, 1);
  EXPECT_NEAR(branches.points[0].z, 11, 1);
  EXPECT_EQ(branches.points[0].share, 1);
  const SectionCrossing found = crossing(cracks, 0, 10.5);
  ASSERT_EQ(found.branches.size(), 2U);
  EXPECT_NEAR(found.position, 13.5, 1e-12) << "the branch that continues";
  EXPECT_EQ(found.branches[0].branch, 1);
  EXPECT_NEAR(found.branches[0].position, plane_0, 1e-12);
  EXPECT_EQ(found.branches[0].share, 1);
  EXPECT_EQ(found.branches[1].branch, 0);
}

TEST_F(CrackPath, PatternsFollowTheSharesOfTheLigaments) {
  struct Case {
    double end_0, end_1;  // notch 0 runs from y = 4 up, notch 1 from y = 12 down
    Pattern expected;
  };
  for (const Case& c :
       {Case{4, 12, Pattern::none}, Case{5, 12, Pattern::none}, Case{16, 12, Pattern::one_crack},
        Case{4, 0, Pattern::one_crack}, Case{16, 9, Pattern::one_crack}, Case{12, 4, Pattern::two_cracks},
        Case{16, 6, Pattern::two_cracks}, Case{7, 12, Pattern::other}, Case{10, 9, Pattern::other}}) {
    const CrackSurface cracks = two_cracks(c.end_0, c.end_1);
    const auto shares = crossed_shares(mesh.body(), cracks);
    std::printf("up to y = %g and %g: shares %.2f, %.2f, pattern %d\n", c.end_0, c.end_1, shares[0],
                shares[1], static_cast<int>(classify(mesh.body(), cracks)));
    EXPECT_NEAR(shares[0], (c.end_0 - 4) / 12, 0.05);
    EXPECT_NEAR(shares[1], (12 - c.end_1) / 12, 0.05);
    EXPECT_EQ(classify(mesh.body(), cracks), c.expected);
  }
}

TEST_F(CrackPath, OverlapIsTheShareInWhichOnePathIsTheOtherTurned) {
  // Within a band of 1.6 m, a tenth of the width, paths overlap.
  struct Case {
    double end_0, end_1, shift;  // notch 1's path is offset from its plane by this
    double expected;
  };
  for (const Case& c : {Case{16, 0, 0, 1}, Case{16, 6, 0, 0.5}, Case{10, 6, 0, 1}, Case{16, 12, 0, 0},
                        Case{16, 0, 1, 1}, Case{16, 0, 3, 0}}) {
    const CrackSurface cracks = surface(
        [&](const Point& p) {
          return p[2] > plane_1 + (p[1] < 12 ? c.shift : 0) ? 2 : p[2] > plane_0 ? 1 : 0;
        },
        [&](const Point& p) {
          const bool first = p[2] < 12 && p[1] > 4 && p[1] < c.end_0;
          const bool second = p[2] > 12 && p[1] < 12 && p[1] > c.end_1;
          return first || second ? 0.0 : -1.0;
        });
    const double found = path_overlap(mesh.body(), cracks, 0, 1);
    std::printf("up to y = %g and %g, %g beside: overlap %.2f\n", c.end_0, c.end_1, c.shift, found);
    EXPECT_NEAR(found, c.expected, 0.09);  // discrete stations, and the step beside the tip
    EXPECT_EQ(path_overlap(mesh.body(), cracks, 1, 0), found);
    EXPECT_EQ(pattern_overlap(mesh.body(), cracks), found);
    if (c.shift == 3) {
      EXPECT_EQ(classify(mesh.body(), cracks), Pattern::other);
    }
    if (c.shift == 1) {
      EXPECT_EQ(classify(mesh.body(), cracks), Pattern::two_cracks);
    }
  }
  EXPECT_TRUE(std::isnan(pattern_overlap(mesh.body(), CrackSurface{})));
}

TEST_F(CrackPath, OverlapTurnsAndDoesNotMirror) {
  // Steps of equal height: once both along +z, once anti-symmetric.
  for (const double sign : {1.0, -1.0}) {
    const CrackSurface cracks = surface(
        [&](const Point& p) {
          return p[2] > plane_1 + (p[1] < 8 ? 3 * sign : 0) ? 2 : p[2] > plane_0 + (p[1] > 8 ? 3 : 0) ? 1 : 0;
        },
        [](const Point& p) { return p[2] < 12.5 ? (p[1] > 4 ? 0.0 : -1.0)
                                    : p[1] < 12 ? 0.0
                                                : -1.0; });
    const double found = path_overlap(mesh.body(), cracks, 0, 1);
    std::printf("steps up and %s: overlap %.2f\n", sign > 0 ? "up" : "down", found);
    EXPECT_TRUE(sign < 0 ? found > 0.9 : found < 0.5);
  }
}

TEST_F(CrackPath, ACrackAwayFromTheNotchesIsAnotherPattern) {
  const CrackSurface cracks = surface([](const Point& p) { return p[2] > 20.5 ? 1 : 0; });
  ASSERT_EQ(cracks.cracks.at(0).start, -1);
  EXPECT_EQ(classify(mesh.body(), cracks), Pattern::other);
  EXPECT_EQ(classify(mesh.body(), CrackSurface{}), Pattern::none);
}

TEST_F(CrackPath, BranchingNeedsLongBranches) {
  struct Case {
    const char* name;
    double start, end;  // the second branch starts at y = start and ends at y = end
    int expected;
  };
  for (const Case& c : {Case{"none", 20, 20, 0}, Case{"long", 7.5, 16, 1}, Case{"short", 7.5, 9, 0}}) {
    const CrackSurface cracks = surface(
        [&](const Point& p) { return p[2] > (p[1] > c.start ? 13.5 : plane_0) ? 2
                                     : p[2] > plane_0                         ? 1
                                                                              : 0; },
        [&](const Point& p) { return p[1] > 4 && !(p[2] > 12 && p[1] > c.end) ? 0.0 : -1.0; });
    const int found = find_branches(mesh.body(), cracks).n_in_space();
    std::printf("%s branch: %d bifurcations\n", c.name, found);
    EXPECT_EQ(found, c.expected);
  }
}

TEST_F(CrackPath, BranchesThatSoonMeetAgainAreNoBifurcation) {
  // Around an island of 5 m in z, 4 m or 7 m long.
  for (const double length : {4.0, 7.0}) {
    const CrackSurface cracks = surface(
        [=](const Point& p) {
          const bool island = p[1] > 6.5 && p[1] < 6.5 + length && p[2] > plane_0 && p[2] < 13.5;
          return island ? 1 : p[2] > plane_0 ? 2 : 0;
        },
        [](const Point& p) { return p[1] > 4 ? 0.0 : -1.0; });
    const int found = find_branches(mesh.body(), cracks).n_in_space();
    std::printf("island of %g m: %d bifurcations\n", length, found);
    EXPECT_EQ(found, length > 5 ? 1 : 0);
    EXPECT_EQ(crossing(cracks, 0, 7.5).branches.size(), 2U);
  }
}

TEST_F(CrackPath, AThreefoldBranchingIsTwoBranchingPoints) {
  const CrackSurface cracks = surface(
      [](const Point& p) {
        const double low = p[1] > 7.5 ? 4.5 : plane_0;
        const double high = p[1] > 7.5 ? 13.5 : plane_0;
        return p[2] > high ? 3 : p[2] > plane_0 ? 2 : p[2] > low ? 1 : 0;
      },
      [](const Point& p) { return p[1] > 4 ? 0.0 : -1.0; });
  EXPECT_EQ(find_branches(mesh.body(), cracks).n_in_space(), 2);
  EXPECT_EQ(crossing(cracks, 0, 12.5).branches.size(), 3U);
}

TEST_F(CrackPath, ACrackThatTurnsBackIsNoBifurcation) {
  // Up in its plane to y = 13, over to z = 13.5 and back down to y = 6.
  const CrackSurface cracks =
      surface([](const Point& p) { return p[1] < 12.5 && p[2] > plane_0 && p[2] < 13.5 ? 1 : 0; },
              [](const Point& p) { return p[1] > (p[2] > 12 ? 6 : 4) ? 0.0 : -1.0; });
  EXPECT_EQ(crossing(cracks, 0, 9.5).branches.size(), 2U);
  EXPECT_EQ(find_branches(mesh.body(), cracks).n_in_space(), 0);
}

/// Accuracy of a speed: the path of a crack is traced and follows the scatter of the tetrahedra a little.
constexpr double accuracy = 1e-3;

TEST_F(CrackPath, SpeedOfAnEvenFrontIsItsOwn) {
  // One layer of cubes after another, at equal intervals.
  const double speed = 250;
  const CrackSurface cracks =
      surface([](const Point& p) { return p[2] > plane_0 ? 1 : 0; },
              [&](const Point& p) { return p[1] > 4 ? std::floor(p[1] - 4) / speed : -1.0; });
  const double found =
      max_crack_speed(mesh.body(), front_trajectories(mesh.body(), cracks, infinity)).largest;
  std::printf("speed %.12g, expected %g\n", found, speed);
  EXPECT_NEAR(found, speed, accuracy * speed);
}

TEST_F(CrackPath, SpeedIsTheLargestOfAWindowAndLeavesTheStartOut) {
  // Half of the ligament before the dynamic phase, then slow, then fast, then slow.
  const auto time = [](const Point& p) {
    const double layer = std::floor(p[1] - 4);
    if (layer < 0) return -1.0;
    return layer < 2 ? 0.0 : layer < 4 ? (layer - 1) / 10 : layer < 10 ? 0.3 + (layer - 4) / 100 : 1.0;
  };
  const double found =
      max_crack_speed(
          mesh.body(),
          front_trajectories(mesh.body(),
                             surface([](const Point& p) { return p[2] > plane_0 ? 1 : 0; }, time), infinity))
          .largest;
  std::printf("fastest window %g, layers at 100 from y = 7 on\n", found);
  EXPECT_GT(found, 95);
  EXPECT_LT(found, 105);
  // The same growth, but all of it before the dynamic phase.
  auto breaks = mesh.break_between([](const Point& p) { return p[2] > plane_0 ? 1 : 0; }, time);
  for (auto& broken : breaks) broken.load_time = -10;
  const auto has_no_speed = [&](const CrackSurface& cracks) {
    return std::isnan(
        max_crack_speed(mesh.body(), front_trajectories(mesh.body(), cracks, infinity)).largest);
  };
  EXPECT_TRUE(has_no_speed(make_crack_surface(mesh.body(), mesh.realization(), breaks, 0)));
  EXPECT_TRUE(has_no_speed(straight(16)));  // all at once, before the dynamic phase
  EXPECT_TRUE(has_no_speed(CrackSurface{}));
}

/// A plate whose crack runs through 36 layers of cubes, with a thickness of several columns.
double speed_through_long_plate(const std::function<double(const Point& p, double layer)>& time) {
  const double plane = 8.5;
  const StructuredMesh mesh(plane::Specimen{{8, 40, 16}, {{plane::Face::y_min, plane, 4, 1}}});
  const auto breaks = mesh.break_between([&](const Point& p) { return p[2] > plane ? 1 : 0; },
                                         [&](const Point& p) {
                                           const double layer = std::floor(p[1] - 4);
                                           return layer < 0 ? -1.0 : time(p, layer);
                                         });
  const double found =
      max_crack_speed(
          mesh.body(),
          front_trajectories(mesh.body(), make_crack_surface(mesh.body(), mesh.realization(), breaks, 0),
                             infinity))
          .largest;
  std::printf("speed %.12g\n", found);
  return found;
}

TEST(CrackSpeed, IsNotThatOfABreakFarAheadThatTheFrontJoinsLater) {
  EXPECT_NEAR(speed_through_long_plate(
                  [](const Point& p, double layer) { return (p[0] < 1 && layer == 25 ? 2 : layer) / 250; }),
              250, 20);
}

TEST(CrackSpeed, LeavesOutTheJumpOverALongIslandButNotTheWayBehindIt) {
  // Twelve layers open early; beyond them the front is twice as fast.
  EXPECT_NEAR(speed_through_long_plate([](const Point&, double layer) {
                if (layer >= 12 && layer < 24) return 1.0 / 250;
                return layer < 12 ? layer / 250 : 14.0 / 250 + (layer - 24) / 500;
              }),
              500, accuracy * 500);
}

TEST(CrackSpeed, OfAFrontThatLeadsFarOnOneSideIsItsOwn) {
  EXPECT_NEAR(speed_through_long_plate(
                  [](const Point& p, double layer) { return (layer + (p[0] < 2.5 ? 0 : 9)) / 250; }),
              250, 2 * accuracy * 250);
}

/// Relative error of the measured speed of synthetic fronts.
class MadeFronts : public testing::Test {
protected:
  using Meshes = std::vector<std::pair<double, double>>;  // spacing and thickness [mm]
  using Arrival = std::function<double(double advance)>;  // arrival time [s] of the front at an advance [mm]
  enum class Rule { centroid, first_node };

  /// @param scatter standard deviation of the position where a tetrahedron breaks [spacings]
  void measure(const Arrival& arrival, const std::function<double(double window)>& speed, double spacing,
               double thickness, Rule rule, double scatter, int n_samples = test::repetitions(2, 6)) {
    double sum = 0;
    double squares = 0;
    worst = 0;
    for (int i = 0; i < n_samples; ++i) {
      const test::MadeCrack crack(spacing, thickness, static_cast<std::uint64_t>(i));
      const CrackSurface surface =
          crack.surface([&](const test::MadeCrack::Tetrahedron& t, RandomStream& noise) {
            const double place = (rule == Rule::centroid ? t.advance : t.least) +
                                 (scatter > 0 ? scatter * spacing * test::normal(noise) : 0);
            return arrival(std::max(place, 1e-3));
          });
      const double ligament = test::MadeCrack::width - test::MadeCrack::depth;
      const double window = std::max(speed_window_share * ligament, speed_window_spacings * spacing);
      const double found =
          max_crack_speed(crack.body(), front_trajectories(crack.body(), surface, infinity)).largest *
          crack.mm();
      const double error = found / speed(window) - 1;
      sum += error;
      squares += error * error;
      worst = std::max(worst, std::abs(error));
    }
    bias = sum / n_samples;
    std::printf("%g mm in %g mm, scatter %.2f%s: bias %.2f %%, deviation %.2f %%, worst %.2f %%\n", spacing,
                thickness, scatter, rule == Rule::first_node ? " from the first node" : "", 100 * bias,
                100 * std::sqrt(std::max(0.0, squares / n_samples - bias * bias)), 100 * worst);
  }

  double bias = 0;
  double worst = 0;
};

TEST_F(MadeFronts, AtConstantSpeed) {
  const int n = test::repetitions(2, 6);
  const auto at = [](double speed) { return [=](double place) { return place / speed; }; };
  const Meshes usual{{0.2, 1.0}, {0.6, 1.0}, {0.5, 2.0}, {0.6, 5.0}};
  const Meshes all{{0.2, 1.0}, {0.4, 1.0}, {0.6, 1.0}, {0.3, 2.0}, {0.5, 2.0}, {0.4, 5.0}, {0.6, 5.0}};
  for (const auto& [spacing, thickness] : test::is_full() ? all : usual) {
    for (const double scatter : {0.0, 0.15}) {
      measure(
          at(500), [](double) { return 500; }, spacing, thickness, Rule::centroid, scatter, n);
      EXPECT_LT(worst, 0.01);
    }
    // With the scatter of the mesh alone, and with far more than real fronts have.
    measure(
        at(500), [](double) { return 500; }, spacing, thickness, Rule::first_node, 0, n);
    EXPECT_LT(std::abs(bias), 0.01);
    measure(
        at(500), [](double) { return 500; }, spacing, thickness, Rule::centroid, 0.3, n);
    EXPECT_LT(std::abs(bias), 0.01);
  }
  for (const double speed : {100.0, 250.0, 1000.0}) {
    measure(
        at(speed), [=](double) { return speed; }, 0.4, 2, Rule::centroid, 0.15, 2);
    EXPECT_LT(worst, 0.01);
  }
}

TEST_F(MadeFronts, WithConstantAcceleration) {
  // From 200 to 600 m/s over the ligament of 19 mm.
  const double acceleration = (600.0 * 600 - 200 * 200) / 2 / 19;
  const auto arrival = [=](double place) {
    return (std::sqrt(200 * 200 + 2 * acceleration * place) - 200) / acceleration;
  };
  const auto largest = [&](double window) { return window / (arrival(19) - arrival(19 - window)); };
  const Meshes usual{{0.2, 1.0}, {0.6, 1.0}, {0.6, 5.0}};
  const Meshes all{{0.2, 1.0}, {0.6, 1.0}, {0.3, 2.0}, {0.4, 5.0}, {0.6, 5.0}};
  for (const auto& [spacing, thickness] : test::is_full() ? all : usual) {
    measure(arrival, largest, spacing, thickness, Rule::centroid, 0);
    EXPECT_LT(worst, 0.01);
  }
  const Meshes scattered{{0.2, 1.0}, {0.3, 2.0}, {0.4, 5.0}};
  for (const auto& [spacing, thickness] : test::is_full() ? scattered : Meshes{{0.3, 2.0}}) {
    measure(arrival, largest, spacing, thickness, Rule::centroid, 0.15, test::repetitions(4, 6));
    EXPECT_LT(std::abs(bias), 0.01);
    EXPECT_LT(worst, 0.03);
  }
}

TEST_F(MadeFronts, ThatAreFastInTheMiddle) {
  // 500 m/s between 6 and 12 mm, 200 m/s before and after.
  const auto arrival = [](double place) {
    return std::min(place, 6.0) / 200 + std::clamp(place - 6, 0.0, 6.0) / 500 +
           std::max(place - 12, 0.0) / 200;
  };
  for (const auto& [spacing, thickness] : {std::pair{0.2, 1.0}, {0.4, 2.0}, {0.4, 5.0}}) {
    for (const double scatter : {0.0, 0.15}) {
      measure(
          arrival, [](double) { return 500; }, spacing, thickness, Rule::centroid, scatter);
      EXPECT_LT(std::abs(bias), 0.01);
    }
  }
}

TEST_F(MadeFronts, ThatJumpOverWhatOpenedAhead) {
  // Facets between 8 and 12 mm open when the front is at 2 mm.
  const auto arrival = [](double place) {
    return place > 8 && place < 12 ? 2.0 / 500 : (place < 8 ? place : place - 3.8) / 500;
  };
  measure(
      arrival, [](double) { return 500; }, 0.4, 2, Rule::centroid, 0);
  EXPECT_LT(worst, 0.01);
}

TEST_F(MadeFronts, DoNotDependOnTheOrderOfWhatBreaksAtOneTime) {
  const test::MadeCrack crack(0.6, 2, 1);
  CrackSurface surface = crack.surface([](const test::MadeCrack::Tetrahedron& t, RandomStream& noise) {
    const double place = t.advance + 0.3 * test::normal(noise);
    return std::ceil(std::max(place + (noise.uniform() < 0.02 ? -4 : 0), 0.1) / 0.4);
  });
  const double found =
      max_crack_speed(crack.body(), front_trajectories(crack.body(), surface, infinity)).largest;
  std::reverse(surface.facets.begin(), surface.facets.end());
  std::stable_sort(surface.facets.begin(), surface.facets.end(),
                   [](const CrackFacet& a, const CrackFacet& b) { return a.time < b.time; });
  EXPECT_NEAR(max_crack_speed(crack.body(), front_trajectories(crack.body(), surface, infinity)).largest,
              found, 1e-9 * found);
}

/// A plate 24 wide (y) and 16 long (z) with notches 4 deep and 1 high: notch 0 in z-min with its plane y =
/// 8.5, notch 1 in y-max with its plane z = 11.5. Their cracks have reached z = 9 and y = 12.
class CrackPathAtZFace : public testing::Test {
protected:
  StructuredMesh mesh{
      plane::Specimen{{4, 24, 16}, {{plane::Face::z_min, 8.5, 4, 1}, {plane::Face::y_max, 11.5, 4, 1}}}};
  CrackSurface cracks = make_crack_surface(
      mesh.body(), mesh.realization(),
      mesh.break_between([](const Point& p) { return p[2] > 11.5  ? 2
                                                     : p[1] > 8.5 ? 1
                                                                  : 0; },
                         [](const Point& p) {
                           if (p[1] < 10) return p[2] > 4 && p[2] < 9 ? std::floor(p[2] - 4) : -1.0;
                           return p[1] > 12 && p[1] < 20 ? std::floor(20 - p[1]) : -1.0;
                         }),
      0);
};

TEST_F(CrackPathAtZFace, CrossesTheSectionsAlongItsLigament) {
  const auto crossings = section_crossings(mesh.body(), cracks, find_branches(mesh.body(), cracks),
                                           planes_of({.y = {8.6, 14.5}, .z = {6.5, 8.5, 9.5}}));
  ASSERT_EQ(crossings.size(), 10u);
  for (const SectionCrossing& found : crossings)
    std::printf("position %.15g, branches %zu\n", found.position, found.branches.size());
  // For notch 0 the sections z = 6.5 and 8.5, at y; for notch 1 the section y = 14.5, at z.
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    const bool arrived = i == 2 || i == 3 || i == 6;
    EXPECT_EQ(crossings[i].branches.size(), arrived ? 1 : 0) << i;
    if (arrived) {
      EXPECT_NEAR(crossings[i].position, i == 6 ? 11.5 : 8.5, 1e-12) << i;
    } else {
      EXPECT_TRUE(std::isnan(crossings[i].position)) << i;
    }
  }
}

TEST_F(CrackPathAtZFace, SectionsOfOneAxisDoNotDependOnTheOther) {
  const auto both = section_crossings(mesh.body(), cracks, find_branches(mesh.body(), cracks),
                                      planes_of({.y = {14.5}, .z = {6.5}}));
  const auto only_z = section_crossings(mesh.body(), cracks, find_branches(mesh.body(), cracks),
                                        planes_of({.y = {}, .z = {6.5}}));
  EXPECT_EQ(only_z.at(0).position, both.at(1).position);
  EXPECT_EQ(only_z.at(0).spread, both.at(1).spread);
}

TEST(CrackPathAtOneZFace, HasAPatternAndASpeed) {
  const StructuredMesh mesh(plane::Specimen{{4, 24, 16}, {{plane::Face::z_min, 8.5, 4, 1}}});
  const auto breaks =
      mesh.break_between([](const Point& p) { return p[1] > 8.5 ? 1 : 0; },
                         [](const Point& p) { return p[2] > 4 ? std::floor(p[2] - 4) : -1.0; });
  const CrackSurface cracks = make_crack_surface(mesh.body(), mesh.realization(), breaks, 0);
  ASSERT_EQ(cracks.cracks.at(0).start, 0);
  EXPECT_EQ(classify(mesh.body(), cracks), Pattern::one_crack);
  EXPECT_NEAR(max_crack_speed(mesh.body(), front_trajectories(mesh.body(), cracks, infinity)).largest, 1,
              accuracy);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::cracks
