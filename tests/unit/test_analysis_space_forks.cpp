// SPDX-License-Identifier: GPL-3.0-or-later
// Forks in space of sheets through a box, on perturbed Delaunay tessellations.
#include "cracks/space_forks.h"
#include "geometry/mother_points.h"
#include "geometry/realization.h"

#include "geometry/body.h"
#include "support/cut_realization.h"
#include "support/effort.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <vector>

namespace crackle::cracks {
namespace CRACKLE_TEST_FILE {

using geometry::Point;

constexpr double spacing = 0.5e-3;  // mean edge length of the tetrahedra [m]
/// Spacing of points whose tetrahedra have that mean edge length.
constexpr double of_points = spacing / 1.16;
// In spacings: a box, and where its sheets meet.
constexpr double thickness = 14, width = 26, height = 24;
constexpr double middle_y = 12, middle_z = 12;

/// Sheets parallel to x. A place has y and z from where they meet, in spacings, and its x.
struct Made {
  const char* name;
  int expected;
  std::function<int(double y, double z)> label;    ///< part of the body
  std::function<double(double y, double z)> time;  ///< when it breaks
  std::function<bool(double x, double y, double z)> is_cracked = [](double, double, double) { return true; };
  double angle = 0;          ///< between the branches [degrees]
  double older_along_x = 0;  ///< what opened before -20 opens the later the larger x is, by this
};

/// Runs along y, then to both sides of it.
Made fork(const char* name, double degrees) {
  const double slope = std::tan(degrees / 2 * std::numbers::pi / 180);
  return {.name = name,
          .expected = 1,
          .label =
              [slope](double y, double z) {
                return y < 0 ? (z > 0 ? 2 : 0) : z > slope * y ? 2 : z > -slope * y ? 1 : 0;
              },
          .time = [](double y, double z) { return y < 0 ? y : std::hypot(y, z); },
          .angle = degrees};
}

/// An upper branch from a sheet that goes straight on, as far as `is_cracked` lets it.
Made side_branch(const char* name, int expected, std::function<bool(double x, double y)> is_there) {
  return {
      .name = name,
      .expected = expected,
      .label = [](double y, double z) { return z < 0   ? 0
                                               : z < y ? 1
                                                       : 2; },
      .time = [](double y, double z) { return y < 0 ? y : std::hypot(y, z); },
      .is_cracked = [is_there](double x, double y, double z) { return z < y / 2 || y < 0 || is_there(x, y); },
      .angle = 45};
}

bool above(double value) {
  return value > 0;
}

const std::vector<Made> sheets{
    {"a flat sheet", 0, [](double, double z) { return above(z); }, [](double y, double) { return y; }},
    {"a sheet bent by 90 degrees", 0, [](double y, double z) { return y < 0 && z > 0; },
     [](double y, double z) { return y < 0 ? y : z; }},
    {"a sheet that stops", 0, [](double, double z) { return above(z); }, [](double y, double) { return y; },
     [](double, double y, double) { return y < 0; }},
    {"two sheets 3 spacings apart", 0, [](double, double z) { return above(z - 1.5) + above(z + 1.5); },
     [](double y, double) { return y; }},
    {"a sheet that ends at an older one", 0, [](double y, double z) { return y > 0 ? 2 : above(z); },
     [](double y, double z) { return y > -1 ? z - 100 : y; }},
    {.name = "a sheet that ends at one that ran across it",
     .expected = 0,
     .label = [](double y, double z) { return y > 0 ? 2 : above(z); },
     .time = [](double y, double) { return y > -1 ? -100 : y; },
     .older_along_x = 1},
    {"a sheet that ends at one older by little", 0, [](double y, double z) { return y > 0 ? 2 : above(z); },
     [](double y, double z) { return y > -1 ? z - 13 : y; }},
    {"a sheet that crosses an older one", 0, [](double y, double z) { return 2 * above(y) + above(z); },
     [](double y, double z) { return std::abs(y) < 1 ? z - 100 : y; }},
    side_branch("a branch 3 spacings long", 0, [](double, double y) { return y < 2.1; }),
    side_branch("a branch 8 spacings long", 1, [](double, double y) { return y < 5.7; }),
    side_branch("a branch over half of the thickness", 1, [](double x, double) { return x < thickness / 2; }),
    fork("branches at 30 degrees", 30),
    fork("branches at 40 degrees", 40),
    fork("branches at 60 degrees", 60),
    fork("branches at 90 degrees", 90),
    fork("branches at 120 degrees", 120),
};

class SheetsInSpace : public testing::Test {
protected:
  static constexpr int n_realizations = 3;

  static void SetUpTestSuite() {
    body = geometry::make_body(plane::Specimen{{thickness * spacing, width * spacing, height * spacing}, {}});
    input::Mesh mesh;
    mesh.spacing = of_points;
    mesh.notch_spacing = of_points;
    mesh.perturbation = 0.2;
    mesh.min_quality = 0.1;
    const auto base = geometry::make_mother_points(*body, mesh, 1);
    for (int i = 0; i < n_realizations; ++i)
      realizations.push_back(geometry::make_realization(*body, base, mesh, 1, static_cast<std::uint64_t>(i)));
  }
  static void TearDownTestSuite() {
    realizations.clear();
    body.reset();
  }

  static std::vector<BranchingPoint> forks(const Made& made, std::uint64_t seed) {
    RandomStream random(seed, 0, "made sheets");
    const double shift_y = random.uniform(-0.5, 0.5), shift_z = random.uniform(-0.5, 0.5);
    const auto y = [&](const Point& p) { return p[1] / spacing - middle_y - shift_y; };
    const auto z = [&](const Point& p) { return p[2] / spacing - middle_z - shift_z; };
    test::Cutting cutting;
    cutting.label = [&](const Point& p) { return made.label(y(p), z(p)); };
    cutting.is_cracked = [&](const Point& p, const auto&) {
      return made.is_cracked(p[0] / spacing, y(p), z(p));
    };
    cutting.time = [&](const Point& p) {
      const double time = made.time(y(p), z(p));
      return time < -20 ? time + made.older_along_x * p[0] / spacing : time;
    };
    cutting.touching = 0.1;
    cutting.random_cuts = 0.5;
    const auto& realization = realizations[seed % n_realizations];
    return find_forks(realization, test::cut(*body, realization, cutting, random.substream(1)));
  }

  static inline std::unique_ptr<const geometry::Body> body;
  static inline std::vector<geometry::Realization> realizations;
};

TEST_F(SheetsInSpace, ForkWhereTwoGrowFromOne) {
  const int n = test::repetitions(n_realizations, 12);
  for (const Made& made : sheets) {
    int n_right = 0;
    double angle = 0, from_line = 0, length = 0;
    for (int i = 0; i < n; ++i) {
      const auto found = forks(made, static_cast<std::uint64_t>(i));
      n_right += std::ssize(found) == made.expected;
      for (const BranchingPoint& point : found) {
        const double share = 1.0 / static_cast<double>(n * std::ssize(found));
        angle += share * point.angle * 180 / std::numbers::pi;
        from_line += share * std::hypot(point.y / spacing - middle_y, point.z / spacing - middle_z);
        length += share * point.length / spacing;
      }
    }
    std::printf("%-40s | %d expected: %2d of %2d", made.name, made.expected, n_right, n);
    if (made.expected > 0)
      std::printf(" | %3.0f degrees: %3.0f, %.1f spacings from the line, %4.1f long", made.angle, angle,
                  from_line, length);
    std::printf("\n");
    EXPECT_GE(n_right, n - n / 10) << made.name;
    if (made.expected == 0) continue;
    EXPECT_NEAR(angle, made.angle, 15) << made.name;
    EXPECT_LT(from_line, 3) << made.name;
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::cracks
