// SPDX-License-Identifier: GPL-3.0-or-later
// Crack paths on perturbed Delaunay tessellations, where crack surfaces are as rough as those of the
// mechanics.
#include "cracks/crack_pattern.h"
#include "cracks/section_crossings.h"
#include "geometry/mother_points.h"
#include "geometry/realization.h"

#include "geometry/body.h"
#include "support/cut_realization.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

namespace crackle::cracks {
namespace CRACKLE_TEST_FILE {

using geometry::Point;

constexpr double mm = 1e-3;
constexpr double spacing = 0.6 * mm;

/// The centre of the paper's plate, with its notches, at z = 15 mm and 25 mm.
class CrackOnRealization : public testing::Test {
protected:
  static void SetUpTestSuite() {
    plane::Specimen specimen{
        {5 * mm, 24.5 * mm, 40 * mm},
        {{plane::Face::y_min, 15 * mm, 6 * mm, 0.6 * mm}, {plane::Face::y_max, 25 * mm, 6 * mm, 0.6 * mm}}};
    input::Mesh mesh;
    mesh.spacing = 1.5 * mm;
    mesh.notch_spacing = spacing;
    mesh.growth = 0.04;
    mesh.perturbation = 0.2;
    mesh.min_quality = 0.1;
    body = geometry::make_body(specimen);
    realization = std::make_unique<geometry::Realization>(
        geometry::make_realization(*body, geometry::make_mother_points(*body, mesh, 3), mesh, 3, 0));
    std::printf("%zu nodes, %zu tetrahedra\n", realization->nodes.size(), realization->tetrahedra.size());
  }
  static void TearDownTestSuite() {
    realization.reset();
    body.reset();
  }

  /// The crack between points of different labels; each break has a random one of the seven cuts, as if
  /// neighbouring tetrahedra chose differently, and there are stray breaks: a share of the tetrahedra that
  /// touch the crack breaks too.
  static CrackSurface crack(const std::function<int(const Point&)>& label,
                            const std::function<bool(const Point&)>& is_cracked, double stray_share) {
    return test::cut(*body, *realization,
                     {.label = label,
                      .is_cracked = [&](const Point& p, const auto&) { return is_cracked(p); },
                      .touching = stray_share},
                     RandomStream(7, 0, "crack"));
  }

  static inline std::unique_ptr<const geometry::Body> body;
  static inline std::unique_ptr<geometry::Realization> realization;
};

/// From the tip of notch 0 upwards, bending away from its plane.
double bent_path(double y) {
  return 15 * mm + 0.012 / mm * (y - 6 * mm) * (y - 6 * mm);
}

TEST_F(CrackOnRealization, RoughCracksAreReadAsOnePath) {
  for (const double stray_share : {0.0, 0.1, 0.3}) {
    const CrackSurface surface = crack([](const Point& p) { return p[2] > bent_path(p[1]) ? 1 : 0; },
                                       [](const Point& p) { return p[1] > 6 * mm; }, stray_share);
    const std::vector<double> sections{7 * mm, 9 * mm, 12.25 * mm, 15.5 * mm, 17.5 * mm, 22 * mm};
    const auto crossings =
        section_crossings(*body, surface, find_branches(*body, surface), planes_of({.y = sections, .z = {}}));
    double worst = 0;
    for (std::size_t s = 0; s < sections.size(); ++s) {
      worst = std::max(worst, std::abs(crossings[s].position - bent_path(sections[s])));
      EXPECT_EQ(crossings[s].branches.size(), 1U) << "y = " << sections[s];
      EXPECT_TRUE(std::isnan(crossings[sections.size() + s].position));
    }
    std::printf("stray share %.1f: %zu cracks, paths to %.3f mm, area ratio %.2f\n", stray_share,
                surface.cracks.size(), worst / mm, surface.area() / (5 * mm * 18.5 * mm));
    EXPECT_LT(worst, spacing / 2);
    EXPECT_EQ(surface.cracks.at(0).start, 0);
    EXPECT_EQ(find_branches(*body, surface).n_in_space(), 0);
    EXPECT_EQ(classify(*body, surface), Pattern::one_crack);
  }
}

TEST_F(CrackOnRealization, RoughBranchesHaveOneBranchingPoint) {
  // At y = 10 mm a second branch leaves at 40 degrees; it ends there, or at 12 mm, which is too short, or at
  // 20 mm.
  const double start = 10 * mm;
  const auto branch = [&](double y) { return 15 * mm - 0.84 * (y - start); };
  for (const double end : {10 * mm, 12 * mm, 20 * mm}) {
    const CrackSurface surface = crack(
        [&](const Point& p) { return p[2] > 15 * mm                        ? 2
                                     : p[1] > start && p[2] > branch(p[1]) ? 1
                                                                           : 0; },
        [&](const Point& p) { return p[1] > 6 * mm && (p[1] < end || p[2] > 14 * mm); }, 0.1);
    const std::vector<double> sections{8 * mm, 18 * mm};
    const auto crossings =
        section_crossings(*body, surface, find_branches(*body, surface), planes_of({.y = sections, .z = {}}));
    const int found = find_branches(*body, surface).n_in_space();
    std::printf("branch to %.0f mm: %d branching points, %zu crossings at 18 mm\n", end / mm, found,
                crossings[1].branches.size());
    const int expected = end > 15 * mm ? 1 : 0;
    EXPECT_EQ(found, expected);
    EXPECT_EQ(crossings[0].branches.size(), 1U);
    EXPECT_EQ(crossings[1].branches.size(), 1 + expected);
  }
}

TEST_F(CrackOnRealization, TwoRoughCracksAreThePatternOfTwo) {
  const CrackSurface surface =
      crack([](const Point& p) { return p[2] > 25 * mm   ? 2
                                        : p[2] > 15 * mm ? 1
                                                         : 0; },
            [](const Point& p) {
              return p[2] < 20 * mm ? p[1] > 6 * mm && p[1] < 17 * mm : p[1] < 18.5 * mm && p[1] > 8 * mm;
            },
            0.1);
  const auto shares = crossed_shares(*body, surface);
  std::printf("shares %.2f and %.2f of 0.59 and 0.57\n", shares[0], shares[1]);
  constexpr double local_spacing = 1 / 18.5;  // at the ends of the cracks, relative to the ligament
  EXPECT_NEAR(shares[0], 11 / 18.5, local_spacing);
  EXPECT_NEAR(shares[1], 10.5 / 18.5, local_spacing);
  EXPECT_EQ(classify(*body, surface), Pattern::two_cracks);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::cracks
