// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/common/index.h"
#include "crackle/geometry/plain_delaunay.h"
#include "crackle/geometry/survey.h"

#include "support/geometry_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace crackle::geometry {
namespace CRACKLE_TEST_FILE {

class SurveyOfPlate : public ::testing::Test {
protected:
  const ExtrudedPlate plate = testing::short_plate();
  const input::Mesh mesh = testing::plate_mesh();
  const MotherPoints base = make_mother_points(plate, mesh, 2012);
  const Survey survey{plate, base, mesh, 2012};
};

TEST_F(SurveyOfPlate, RowsDescribeTheRealizations) {
  std::array<DisplacementSums, 3> sums;
  OrientationMoments mean;
  constexpr int n_samples = 20;
  double slowest = 0;
  for (std::uint64_t sample = 0; sample < n_samples; ++sample) {
    Realization seen;
    const SurveyRow row = survey.measure(sample, [&](const Realization& made) { seen = made; });
    ASSERT_EQ(row.error, "");
    EXPECT_EQ(row.sample, sample);
    EXPECT_EQ(seen.nodes, make_realization(plate, base, mesh, 2012, sample).nodes);
    EXPECT_EQ(row.n_tetrahedra, static_cast<std::int64_t>(seen.tetrahedra.size()));
    EXPECT_EQ(row.report.redrawn_points, seen.report.redrawn_points);
    EXPECT_NEAR(row.mesh.quality.smallest, row.report.min_quality, 1e-12);
    EXPECT_GT(row.seconds, 0);
    EXPECT_GT(row.delaunay_seconds, 0);
    slowest = std::max(slowest, row.seconds / row.delaunay_seconds);
    for (std::size_t kind = 0; kind < 3; ++kind) sums[kind].add(row.displacement[kind]);
    add_share(mean, row.orientation, 1.0 / n_samples);
  }
  std::printf("at most %.2f times the time of a plain tessellation; bias of the mean %.4f and %.4f\n",
              slowest, second_order_bias(mean), fourth_order_bias(mean));
  EXPECT_NEAR(mean.second[0][0] + mean.second[1][1] + mean.second[2][2], 1, 1e-12);
  EXPECT_LT(second_order_bias(mean), 0.02);
  EXPECT_LT(fourth_order_bias(mean), 0.02);

  // Uniform along an edge, in a disc and in a ball.
  const std::array<double, 3> uniform{1.0 / 3, 1.0 / 4, 1.0 / 5};
  for (std::size_t kind = 0; kind < 3; ++kind)
    for (std::size_t i = 0; i < 3; ++i) {
      const double chance = 4 * std::sqrt(uniform[kind] / sums[kind].n[i]);
      std::printf("%zu movable coordinates, axis %zu: %6.0f displacements, mean %.4f, variance %.4f\n",
                  kind + 1, i, sums[kind].n[i], sums[kind].mean(i), sums[kind].covariance(i, i));
      EXPECT_NEAR(sums[kind].mean(i), 0, chance);
      EXPECT_NEAR(sums[kind].covariance(i, i), uniform[kind], chance);
    }
}

TEST_F(SurveyOfPlate, FineZoneIsInsideAndFine) {
  const FineZone zone(plate, mesh);
  EXPECT_TRUE(zone.contains({1.5e-3, 5e-3, 9e-3}));
  EXPECT_FALSE(zone.contains({1.5e-3, 4.3e-3, 9e-3})) << "near the tip";
  EXPECT_FALSE(zone.contains({0.3e-3, 6e-3, 9e-3})) << "near a face";
  EXPECT_FALSE(zone.contains({1.5e-3, 8e-3, 2e-3})) << "coarse";
  EXPECT_GT(survey.base_orientation().area, 0);
}

TEST_F(SurveyOfPlate, RealizationsThatFailAreRows) {
  input::Mesh undisturbed = mesh;
  undisturbed.perturbation = 0;
  MotherPoints twice = base;
  twice.position[100] = twice.position[101];
  const SurveyRow row = Survey(plate, twice, undisturbed, 2012).measure(3);
  EXPECT_NE(row.error.find("two points coincide"), std::string::npos) << row.error;
  EXPECT_EQ(row.n_tetrahedra, 0);
}

TEST_F(SurveyOfPlate, PlainTessellationHasTheSameTetrahedra) {
  const Realization made = make_realization(plate, base, mesh, 2012, 0);
  const PlainDelaunay plain = plain_delaunay(made.nodes);
  const auto corners = [](const std::vector<Point>& nodes, const Tetrahedron& t) {
    std::array<Point, 4> points{};
    for (std::size_t k = 0; k < 4; ++k) points[k] = nodes[index(t[k])];
    std::sort(points.begin(), points.end());
    return points;
  };
  std::set<std::array<Point, 4>> cells;
  for (const Tetrahedron& t : plain.tetrahedra) cells.insert(corners(plain.nodes, t));
  EXPECT_EQ(plain.nodes.size(), made.nodes.size());
  EXPECT_GT(plain.tetrahedra.size(), made.tetrahedra.size()) << "the notches are filled";
  for (const Tetrahedron& t : made.tetrahedra) ASSERT_TRUE(cells.contains(corners(made.nodes, t)));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::geometry
