// SPDX-License-Identifier: GPL-3.0-or-later
// Detection rates and false positives of branching, on perturbed Delaunay tessellations cut by synthetic
// surfaces.
#include "common/index.h"
#include "cracks/branching.h"
#include "geometry/mother_points.h"
#include "geometry/realization.h"

#include "geometry/body.h"
#include "support/cut_realization.h"
#include "support/effort.h"

#include <gmock/gmock.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

namespace crackle::cracks {
namespace CRACKLE_TEST_FILE {

using geometry::Point;

// In spacings: a plate 8 thick, 34 wide and 40 long, with a notch that ends at y = 4, z = 20.
constexpr double thickness = 8;
constexpr double tip = 3;
constexpr double width = 28;
constexpr double plane = 18;
constexpr double spacing = 0.5e-3;  // mean edge length of the tetrahedra [m]
/// Spacing of points whose tetrahedra have that mean edge length.
constexpr double of_points = spacing / 1.16;

/// A random smooth surface height over x and y [spacings].
class Roughness {
public:
  Roughness(double amplitude, RandomStream& random) {
    constexpr int n = 12;
    for (int i = 0; i < n; ++i) {
      const double wave = 2 * std::numbers::pi / random.uniform(3, 12);
      const double direction = random.uniform(0, 2 * std::numbers::pi);
      waves_.push_back({wave * std::cos(direction), wave * std::sin(direction),
                        random.uniform(0, 2 * std::numbers::pi), amplitude * std::sqrt(2.0 / n)});
    }
  }
  double operator()(double x, double y) const {
    double height = 0;
    for (const Wave& w : waves_) height += w.size * std::cos(w.x * x + w.y * y + w.phase);
    return height;
  }

private:
  struct Wave {
    double x, y, phase, size;
  };
  std::vector<Wave> waves_;
};

/// A synthetic crack along z = plane with branches; lengths in spacings, angles in degrees.
struct Made {
  const char* name = "";
  int branches = 2;         ///< 1: no branching
  double length = 10;       ///< of the shorter branches
  double half_angle = 20;   ///< between neighbouring branches
  double share = 1;         ///< of the thickness, covered by the shorter branches
  double roughness = 0.2;   ///< standard deviation of the surface heights
  double touching = 0.1;    ///< share of the tetrahedra next to the crack that break
  double strays = 0;        ///< single breaks per spacing of crack advance
  double distance = 0;      ///< non-zero: the branches are parallel at this distance instead of at an angle
  double s_shape = 0;       ///< amplitude of the path
  double tilt = 0;          ///< of the crack through the thickness
  bool is_twisted = false;  ///< each half of the thickness contains one of the branches
  bool has_spurs = false;   ///< branches of 2 spacings at several places
  bool meets = false;       ///< parallel branches that meet once
};

struct Counts {
  int samples = 0;
  int projected = 0;  ///< samples in which the correct number of branching points was found
  int in_space = 0;
  int any_projected = 0;  ///< samples with any branching
  int any_in_space = 0;
};

class MadeBranches : public testing::Test {
protected:
  static constexpr int n_realizations = 4;

  static void SetUpTestSuite() {
    const plane::Specimen specimen{{thickness * spacing, width * spacing, 2 * plane * spacing},
                                   {{plane::Face::y_min, plane * spacing, tip * spacing, spacing}}};
    input::Mesh mesh;
    mesh.spacing = of_points;
    mesh.notch_spacing = of_points;
    mesh.perturbation = 0.2;
    mesh.min_quality = 0.1;
    body = geometry::make_body(specimen);
    const auto base = geometry::make_mother_points(*body, mesh, 1);
    for (int i = 0; i < n_realizations; ++i)
      realizations.push_back(geometry::make_realization(*body, base, mesh, 1, static_cast<std::uint64_t>(i)));
    const CrackSurface straight = make({.branches = 1, .roughness = 0, .touching = 0}, 0);
    double mean = 0;
    for (const CrackFacet& facet : straight.facets)
      mean += local_spacing(facet) / static_cast<double>(straight.facets.size());
    std::printf("%zu tetrahedra; mean local spacing %.3f\n", realizations[0].tetrahedra.size(),
                mean / spacing);
  }
  static void TearDownTestSuite() {
    realizations.clear();
    body.reset();
  }

  static CrackSurface make(const Made& made, std::uint64_t seed) {
    RandomStream random(seed, 0, "made fork");
    const double split = made.has_spurs ? 6 : random.uniform(5, 8);
    const double above = random.uniform(-0.5, 0.5);
    const double phase = random.uniform(0, 2 * std::numbers::pi);
    const bool is_up = random.uniform() < 0.5;  // selects the shorter one of two branches
    const double covered = made.share * thickness;
    const double first_x = random.uniform(0, thickness - covered);
    std::vector<Roughness> surface;
    for (int i = 0; i < 3; ++i) surface.emplace_back(made.roughness, random);
    const double slope = std::tan(made.half_angle * std::numbers::pi / 180);

    const auto trunk = [&](double x, double y) {
      return plane + above + made.tilt * (x - thickness / 2) +
             made.s_shape * (std::sin(2 * std::numbers::pi * (y - tip) / 30 + phase) - std::sin(phase));
    };
    // Heights of the branches in ascending order; branches meet where they cross due to roughness.
    const auto heights = [&](const Point& p) {
      const double x = p[0] / spacing;
      const double y = p[1] / spacing;
      const double past = std::max(0.0, y - tip - split);
      double half = made.distance > 0 ? std::min(past * 2, made.distance / 2) : past * slope;
      if (made.meets) half = std::min(half, 2 * std::max(0.0, std::abs(past - 6) - 0.5));
      std::array<double, 3> z{};
      for (int i = 0; i < made.branches; ++i) {
        const auto k = static_cast<std::size_t>(i);
        // Before the branching all are the same surface; beyond it each has its own roughness.
        const double own = std::min(past / 2, 1.0);
        const double rough_z = (1 - own) * surface[0](x, y) + own * surface[k](x, y);
        z[k] = trunk(x, y) + rough_z + (2.0 * i - (made.branches - 1)) * half;
        if (i > 0) z[k] = std::max(z[k], z[k - 1]);
      }
      return z;
    };
    // The long arm is the last or the first; of three the middle one.
    const int main = made.branches == 3 ? 1 : is_up ? 0 : made.branches - 1;
    test::Cutting cutting;
    cutting.label = [&](const Point& p) {
      // Most nodes are far from all branches.
      const double away = std::abs(p[2] / spacing - trunk(p[0] / spacing, p[1] / spacing));
      const double past = std::max(0.0, p[1] / spacing - tip - split);
      if (away > 3 + 4 * made.roughness +
                     (made.branches == 1 ? 0 : std::max(made.distance, past * slope * (made.branches - 1))))
        return p[2] / spacing > trunk(p[0] / spacing, p[1] / spacing) ? made.branches : 0;
      const auto z = heights(p);
      int label = 0;
      for (int i = 0; i < made.branches; ++i) label += p[2] / spacing > z[index(i)] ? 1 : 0;
      return label;
    };
    cutting.is_cracked = [&](const Point& p, const std::array<int, 4>& labels) {
      const double x = p[0] / spacing;
      const double past = p[1] / spacing - tip - split;
      if (p[1] < tip * spacing) return false;
      if (past < 0) return true;
      const auto [low, high] = std::minmax_element(labels.begin(), labels.end());
      for (int branch = *low; branch < *high; ++branch) {  // between label branch and label branch + 1
        if (made.is_twisted) {
          if ((x < thickness / 2) == (branch == 0)) return true;
        } else if (branch == main) {
          return true;
        } else if (x >= first_x && x <= first_x + covered) {
          if (made.has_spurs ? std::fmod(past, 6) < made.length
                             : past * (made.distance > 0 ? 1 : std::hypot(1, slope)) < made.length)
            return true;
        }
      }
      return false;
    };
    cutting.touching = made.touching;
    if (made.strays > 0) {
      cutting.is_stray = [&](const Point& p, RandomStream& stream) {
        const double y = p[1] / spacing;
        if (y < tip || std::abs(p[2] / spacing - trunk(p[0] / spacing, y)) > 4) return false;
        // There are about 9 tetrahedra per cube of one spacing.
        return stream.uniform() < made.strays / (9 * 8 * thickness);
      };
    }
    cutting.random_cuts = 0.5;
    return test::cut(*body, realizations[seed % n_realizations], cutting, random.substream(1));
  }

  static Counts count(const Made& made, int n) {
    Counts counts;
    const int expected = made.has_spurs ? 0 : made.branches - 1;
    for (int i = 0; i < n; ++i) {
      const CrackBranches branches = find_branches(*body, make(made, static_cast<std::uint64_t>(i)));
      ++counts.samples;
      counts.projected += branches.n_projected() == expected;
      counts.in_space += branches.n_in_space() == expected;
      counts.any_projected += branches.n_projected() > 0;
      counts.any_in_space += branches.n_in_space() > 0;
    }
    std::printf("%-52s | %3d | %5.1f %5.1f | %5.1f %5.1f\n", made.name, n, 100.0 * counts.projected / n,
                100.0 * counts.in_space / n, 100.0 * counts.any_projected / n,
                100.0 * counts.any_in_space / n);
    return counts;
  }
  static void head() {
    std::printf("%-52s | %3s | %11s | %11s\n", "made crack", "n", "right [%]", "any [%]");
    std::printf("%-52s | %3s | %5s %5s | %5s %5s\n", "", "", "proj.", "space", "proj.", "space");
  }

  static inline std::unique_ptr<const geometry::Body> body;
  static inline std::vector<geometry::Realization> realizations;
};

// In spacings. Each row gives the minimum share of correct results, in the projection and in space [%].
struct Row {
  Made made;
  double projected;
  double in_space;
};

// Branches at least two spacings apart over a length of four: these are found.
const std::vector<Row> branched{
    {{.name = "half angle 20 degrees, 7 long", .length = 6.9}, 90, 95},
    {{.name = "half angle 30 degrees, 6 long", .length = 6, .half_angle = 30}, 95, 95},
    {{.name = "half angle 45 degrees, 5.4 long", .length = 5.4, .half_angle = 45}, 95, 95},
    {{.name = "side by side at 4, 4 long", .length = 4, .distance = 4}, 95, 95},
    {{.name = "over half of the thickness", .share = 0.5}, 95, 95},
    {{.name = "over 0.3 of the thickness", .share = 0.3}, 95, 95},
    {{.name = "roughness 0.4", .roughness = 0.4}, 95, 90},
    {{.name = "wide", .touching = 0.3}, 95, 95},
    {{.name = "many strays", .strays = 3}, 90, 95},
    {{.name = "three branches", .branches = 3}, 95, 95},
    {{.name = "tilted by 1:2", .tilt = 0.5}, 0, 95},
};

// The branches' own thickness and roughness close the gap; reported, not asserted.
const std::vector<Row> at_the_limit{
    {{.name = "half angle 10 degrees, 9.8 long", .length = 9.8, .half_angle = 10}, 0, 0},
    {{.name = "half angle 20 degrees, 4 long", .length = 4}, 0, 0},
    {{.name = "half angle 20 degrees, 5 long", .length = 5}, 0, 0},
    {{.name = "half angle 20 degrees, 10 long", .length = 10}, 0, 0},
    {{.name = "side by side at 2, 4 long", .length = 4, .distance = 2}, 0, 0},
    {{.name = "side by side at 2, 6 long", .length = 6, .distance = 2}, 0, 0},
    {{.name = "side by side at 3, 4 long", .length = 4, .distance = 3}, 0, 0},
    {{.name = "side by side at 3, 6 long", .length = 6, .distance = 3}, 0, 0},
    {{.name = "over 0.15 of the thickness", .share = 0.15}, 0, 0},
    {{.name = "three branches over half of the thickness", .branches = 3, .share = 0.5}, 0, 0},
    {{.name = "roughness 0.6, wide, many strays", .roughness = 0.6, .touching = 0.3, .strays = 3}, 0, 0},
};

const std::vector<Row> unbranched{
    {{.name = "straight", .branches = 1}, 99, 99},
    {{.name = "straight, rough, wide", .branches = 1, .roughness = 0.4, .touching = 0.3}, 99, 99},
    {{.name = "straight, many strays", .branches = 1, .strays = 3}, 99, 99},
    {{.name = "S-shaped, rough, strays", .branches = 1, .roughness = 0.4, .strays = 1, .s_shape = 4}, 99, 99},
    {{.name = "tilted", .branches = 1, .tilt = 0.7}, 99, 99},
    {{.name = "spurs of 2", .length = 2, .has_spurs = true}, 95, 95},
};

TEST_F(MadeBranches, AreFound) {
  head();
  for (const Row& row : branched) {
    const Counts found = count(row.made, test::repetitions(4, 12));
    EXPECT_GE(found.projected, std::floor(row.projected / 100 * found.samples)) << row.made.name;
    EXPECT_GE(found.in_space, std::floor(row.in_space / 100 * found.samples)) << row.made.name;
  }
}

TEST_F(MadeBranches, AreNotFoundInOneCrack) {
  head();
  for (const Row& row : unbranched) {
    const Counts found = count(row.made, row.made.name == std::string("straight") ? test::repetitions(20, 200)
                                                                                  : test::repetitions(4, 12));
    EXPECT_GE(found.projected, row.projected / 100 * found.samples) << row.made.name;
    EXPECT_GE(found.in_space, row.in_space / 100 * found.samples) << row.made.name;
  }
}

TEST_F(MadeBranches, ThatMeetAndPartAgainHaveTheirWholeLength) {
  const int n = test::repetitions(16, 40);
  int n_whole = 0;
  for (int i = 0; i < n; ++i) {
    const Made made{.length = 9.5, .distance = 4, .meets = true};
    const CrackBranches branches = find_branches(*body, make(made, static_cast<std::uint64_t>(i)));
    // From the first branching on; either part alone is shorter.
    n_whole += std::ranges::any_of(branches.points, [](const BranchingPoint& point) {
      return point.is_in_projection && point.length > 7 * spacing;
    });
  }
  std::printf("%d of %d branches have their whole length\n", n_whole, n);
  EXPECT_GE(n_whole, n * 3 / 4);
}

TEST_F(MadeBranches, OfATwistedCrackAreInTheProjectionOnly) {
  head();
  const Counts found = count({.name = "twisted", .length = 20, .is_twisted = true}, 10);
  EXPECT_EQ(found.projected, 10);
  EXPECT_EQ(found.any_projected, 10);
}

// All rows with 200 samples each: takes minutes.
TEST_F(MadeBranches, DISABLED_Table) {
  head();
  for (const auto* rows : {&branched, &at_the_limit, &unbranched})
    for (const Row& row : *rows) count(row.made, 200);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::cracks
