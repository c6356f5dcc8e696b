// SPDX-License-Identifier: GPL-3.0-or-later
// The candidate crack facets have no preferred planes.
#include "common/index.h"
#include "common/vector.h"
#include "geometry/dual_facets.h"
#include "geometry/point.h"

#include "support/effort.h"
#include "support/geometry_bodies.h"

#include <gtest/gtest.h>
#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace crackle::geometry {
namespace CRACKLE_TEST_FILE {

using Fourth = Eigen::Matrix<double, 9, 9>;  ///< row 3 i + j and column 3 k + l: component i, j, k, l

/// Orientation of the candidate crack facets: means of n n and of n n n n over the normals n of the dual
/// facets, weighted by area.
struct OrientationMoments {
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  Fourth fourth = Fourth::Zero();
};

/// Over the tetrahedra with centroid in the region.
OrientationMoments moments_in(const Realization& realization, const Box& region) {
  OrientationMoments moments;
  double total = 0;
  const DualSurface surface = dual_surface(realization);
  for (std::size_t q = 0; q < surface.quadrilaterals.size(); ++q) {
    if (!region.contains(centroid(realization.nodes, realization.tetrahedra[index(surface.tetrahedron[q])])))
      continue;
    const auto corner = [&](std::size_t i) { return surface.points[index(surface.quadrilaterals[q][i])]; };
    const Point facet = cross(corner(2) - corner(0), corner(3) - corner(1)) / 2;
    const double area = norm(facet);
    const Eigen::Vector3d normal = Eigen::Vector3d(facet.data()) / area;
    const Eigen::Matrix3d pair = normal * normal.transpose();
    const Eigen::Map<const Eigen::Vector<double, 9>> pairs(pair.data());
    total += area;
    moments.second += area * pair;
    moments.fourth += area * pairs * pairs.transpose();
  }
  moments.second /= total;
  moments.fourth /= total;
  return moments;
}

/// Distance of the second moment from the isotropic one, delta_ij / 3, relative to the latter (Frobenius
/// norms): 0 for no preferred direction, 1.41 if all normals are parallel.
double second_order_bias(const OrientationMoments& moments) {
  const Eigen::Matrix3d isotropic = Eigen::Matrix3d::Identity() / 3;
  return (moments.second - isotropic).norm() / isotropic.norm();
}

/// As second_order_bias for the fourth moment, whose isotropic value is (delta_ij delta_kl + delta_ik
/// delta_jl + delta_il delta_jk) / 15. It detects the planes of a cubic lattice, which are isotropic to
/// second order.
double fourth_order_bias(const OrientationMoments& moments) {
  Fourth isotropic = Fourth::Zero();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      isotropic(4 * i, 4 * j) += 1.0 / 15;
      isotropic(3 * i + j, 3 * i + j) += 1.0 / 15;
      isotropic(3 * i + j, 3 * j + i) += 1.0 / 15;
    }
  return (moments.fourth - isotropic).norm() / isotropic.norm();
}

using testing::mm;

/// Bounds on the bias of one realization: for about 10,000 tetrahedra, chance alone gives about half of them.
constexpr double second_order_bound = 0.02;
constexpr double fourth_order_bound = 0.02;

/// Bound on the bias of the mean over 20 realizations, for both orders; chance contributes little. Perturbed
/// lattices have 3 to 8 times as much in the fourth order.
constexpr double mean_bound = 0.01;

const Body box = testing::body({5, 5, 5});
const Box interior{{0.8 * mm, 0.8 * mm, 0.8 * mm}, {4.2 * mm, 4.2 * mm, 4.2 * mm}};

/// A cubic or body-centred lattice with as many points as the blue noise.
MotherPoints lattice(bool body_centred) {
  const int n = body_centred ? 10 : 13;
  MotherPoints points;
  const auto add = [&](double i, double j, double k) {
    Point p{i, j, k};
    for (double& coordinate : p) coordinate = coordinate == n ? 5 * mm : coordinate * 5 * mm / n;
    points.position.push_back(p);
    points.spacing.push_back(0.4 * mm);
    points.movable.push_back(box.movable(p));
  };
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j)
      for (int k = 0; k <= n; ++k) {
        add(i, j, k);
        if (body_centred && i < n && j < n && k < n) add(i + 0.5, j + 0.5, k + 0.5);
      }
  return points;
}

OrientationMoments measure(const char* name, const MotherPoints& base, double perturbation,
                           std::uint64_t sample, double min_quality) {
  input::Mesh parameters = testing::mesh(0.4, 0.4);
  parameters.perturbation = perturbation;
  parameters.min_quality = min_quality;
  const Realization made = make_realization(box, base, parameters, 2012, sample);
  const OrientationMoments moments = moments_in(made, interior);
  std::printf("%-20s perturbation %.2f: %6zu tetrahedra, bias of second order %.4f, of fourth order %.4f\n",
              name, perturbation, made.tetrahedra.size(), second_order_bias(moments),
              fourth_order_bias(moments));
  return moments;
}

TEST(Bias, BlueNoiseHasNone) {
  const MotherPoints base = make_mother_points(box, testing::mesh(0.4, 0.4), 2012);
  for (const auto& [perturbation, n_samples] : {std::pair{0.0, 1}, std::pair{0.2, 5}, std::pair{0.35, 2}})
    for (int sample = 0; sample < n_samples; ++sample) {
      const OrientationMoments moments =
          measure("blue noise", base, perturbation, static_cast<std::uint64_t>(sample), 0.2);
      EXPECT_LT(second_order_bias(moments), second_order_bound);
      EXPECT_LT(fourth_order_bias(moments), fourth_order_bound);
    }
}

TEST(Bias, LatticesHaveMuch) {
  for (const double perturbation : {0.2, 0.35})
    for (const bool body_centred : {false, true}) {
      const OrientationMoments moments = measure(body_centred ? "body-centred lattice" : "cubic lattice",
                                                 lattice(body_centred), perturbation, 0, 0.01);
      EXPECT_GT(fourth_order_bias(moments), 1.2 * fourth_order_bound);
    }
}

/// The second- and fourth-order bias of the mean moments of realizations.
/// @param bases mother points, used by the realizations in turn
std::array<double, 2> mean_bias(const char* name, double perturbation, double min_quality,
                                const std::vector<MotherPoints>& bases, int n_realizations) {
  input::Mesh parameters = testing::mesh(0.4, 0.4);
  parameters.perturbation = perturbation;
  parameters.min_quality = min_quality;
  OrientationMoments mean;
  for (std::size_t i = 0; i < index(n_realizations); ++i) {
    const Realization made = make_realization(box, bases[i % bases.size()], parameters, 2012, i);
    const OrientationMoments moments = moments_in(made, interior);
    mean.second += moments.second / n_realizations;
    mean.fourth += moments.fourth / n_realizations;
  }
  const std::array<double, 2> bias{second_order_bias(mean), fourth_order_bias(mean)};
  std::printf("%-20s perturbation %.2f, mean of %d realizations: bias of second order %.4f, of fourth %.4f\n",
              name, perturbation, n_realizations, bias[0], bias[1]);
  return bias;
}

TEST(Bias, MeanOverRealizations) {
  std::vector<MotherPoints> noise;
  for (std::uint64_t seed = 0; seed < 5; ++seed)
    noise.push_back(make_mother_points(box, testing::mesh(0.4, 0.4), seed));
  for (const double perturbation : {0.2, 0.35}) {
    if (perturbation > 0.2 && !test::is_full()) continue;
    const auto [second, fourth] = mean_bias("blue noise", perturbation, 0.2, noise, 20);
    EXPECT_LT(second, mean_bound);
    EXPECT_LT(fourth, mean_bound);
    const int n = test::repetitions(4, 20);
    EXPECT_GT(mean_bias("cubic lattice", perturbation, 0.01, {lattice(false)}, n)[1], 2.5 * mean_bound);
    EXPECT_GT(mean_bias("body-centred lattice", perturbation, 0.01, {lattice(true)}, n)[1], 2.5 * mean_bound);
  }
}

// Tests the measure itself, on facets with known moments.
TEST(Bias, MomentsOfKnownFacets) {
  // The normals of the regular tetrahedron's dual facets are its six edges, isotropic to second order only.
  Realization regular;
  regular.nodes = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  regular.tetrahedra = {{0, 2, 1, 3}};
  const OrientationMoments moments = moments_in(regular, {{-1, -1, -1}, {1, 1, 1}});
  EXPECT_NEAR(second_order_bias(moments), 0, 1e-14);
  // Edges along (1,1,0) and its five equivalents: <n_x^4> = 4/6 * 1/4 = 1/6, <n_x^2 n_y^2> = 2/6 * 1/4 =
  // 1/12; isotropic are 1/5 and 1/15.
  EXPECT_NEAR(moments.fourth(0, 0), 1.0 / 6, 1e-14);
  EXPECT_NEAR(moments.fourth(0, 4), 1.0 / 12, 1e-14);
  const double deviation = 3 * std::pow(1.0 / 6 - 1.0 / 5, 2) + 18 * std::pow(1.0 / 12 - 1.0 / 15, 2);
  const double isotropic = 3 * std::pow(1.0 / 5, 2) + 18 * std::pow(1.0 / 15, 2);
  EXPECT_NEAR(fourth_order_bias(moments), std::sqrt(deviation / isotropic), 1e-13);
}

TEST(DualFacets, SurfaceSharesItsPoints) {
  const Body small = testing::body({1, 1, 1});
  const input::Mesh parameters = testing::mesh(0.5, 0.5);
  const Realization made =
      make_realization(small, make_mother_points(small, parameters, 1), parameters, 1, 0);
  const DualSurface surface = dual_surface(made);
  const auto n_tetrahedra = made.tetrahedra.size();
  const auto n_faces = (4 * n_tetrahedra + made.boundary.size()) / 2;
  // Euler: nodes - edges + faces - tetrahedra = 1 for a ball.
  const auto n_edges = made.nodes.size() + n_faces - n_tetrahedra - 1;
  EXPECT_EQ(surface.points.size(), n_edges + n_faces + n_tetrahedra);
  EXPECT_EQ(surface.quadrilaterals.size(), 6 * n_tetrahedra);
  EXPECT_EQ(surface.tetrahedron.back(), static_cast<std::int32_t>(n_tetrahedra - 1));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::geometry
