// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/index.h"
#include "mechanics/internal_force.h"
#include "mechanics/operators.h"

#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <vector>

namespace crackle::mechanics {
namespace CRACKLE_TEST_FILE {

using geometry::Point;

geometry::Realization disturbed_box() {
  return test::make_box({.size = {0.005, 0.01, 0.02}, .cells = {3, 4, 6}, .disturbance = 0.2});
}

Point midpoint(const std::vector<Point>& points) {
  Point sum{};
  for (const auto& p : points) {
    for (std::size_t i = 0; i < 3; ++i) sum[i] += p[i] / static_cast<double>(points.size());
  }
  return sum;
}

/// Vector area of a polygon, as half the sum of the cross products of its fan.
Vector vector_area(const std::vector<Point>& corners) {
  Vector area{};
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    Vector a{}, b{};
    for (std::size_t k = 0; k < 3; ++k) {
      a[k] = corners[i][k] - corners[0][k];
      b[k] = corners[i + 1][k] - corners[0][k];
    }
    const Vector n = cross(a, b);
    for (std::size_t k = 0; k < 3; ++k) area[k] += n[k] / 2;
  }
  return area;
}

TEST(Operators, GradientIsThatOfLinearShapeFunctions) {
  const auto mesh = disturbed_box();
  const auto subdomain = test::whole(mesh);
  double worst = 0;
  for (const auto& t : make_operators(subdomain, 1).tetrahedra) {
    // grad N_a . (x_b - x_c) = delta_ab - delta_ac defines the gradient.
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 1; b < 4; ++b) {
        Vector edge{};
        for (std::size_t i = 0; i < 3; ++i) {
          edge[i] = subdomain.nodes[index(t.nodes[b])][i] - subdomain.nodes[index(t.nodes[0])][i];
        }
        const double expected = (a == b ? 1.0 : 0.0) - (a == 0 ? 1.0 : 0.0);
        worst = std::max(worst, std::abs(dot(t.gradient[a], edge) - expected));
      }
    }
  }
  std::printf("largest deviation of b from grad N: %.2e\n", worst);
  EXPECT_LT(worst, 1e-13);
}

TEST(Operators, FacetFormEqualsGradientForm) {
  const auto mesh = disturbed_box();
  const auto subdomain = test::whole(mesh);
  double worst = 0;
  for (const auto& t : make_operators(subdomain, 1).tetrahedra) {
    std::array<Point, 4> x{};
    for (std::size_t a = 0; a < 4; ++a) x[a] = subdomain.nodes[index(t.nodes[a])];
    const double scale = std::cbrt(t.volume) * std::cbrt(t.volume);
    for (int a = 0; a < 4; ++a) {
      Vector sum{};
      for (int b = 0; b < 4; ++b) {
        if (a == b) continue;
        const Vector area = t.volume / 4 * (t.gradient[index(b)] - t.gradient[index(a)]);  // S^ab
        for (std::size_t i = 0; i < 3; ++i) sum[i] += area[i];
        // The quadrilateral: edge midpoint, face centroid, tetrahedron centroid, face centroid.
        std::vector<std::size_t> others;
        for (std::size_t c = 0; c < 4; ++c) {
          if (static_cast<int>(c) != a && static_cast<int>(c) != b) others.push_back(c);
        }
        const auto ua = static_cast<std::size_t>(a);
        const auto ub = static_cast<std::size_t>(b);
        Vector facet =
            vector_area({midpoint({x[ua], x[ub]}), midpoint({x[ua], x[ub], x[others[0]]}),
                         midpoint({x[0], x[1], x[2], x[3]}), midpoint({x[ua], x[ub], x[others[1]]})});
        Vector direction{};
        for (std::size_t i = 0; i < 3; ++i) direction[i] = x[ub][i] - x[ua][i];
        const double sign = dot(facet, direction) > 0 ? 1 : -1;
        for (std::size_t i = 0; i < 3; ++i)
          worst = std::max(worst, std::abs(sign * facet[i] - area[i]) / scale);
      }
      for (std::size_t i = 0; i < 3; ++i) {
        worst = std::max(worst, std::abs(sum[i] + t.volume * t.gradient[index(a)][i]) / scale);
      }
    }
  }
  std::printf("largest deviation of the facet form: %.2e\n", worst);
  EXPECT_LT(worst, 1e-13);
}

TEST(Operators, MassAddsUpToDensityTimesVolume) {
  const auto mesh = disturbed_box();
  const auto subdomain = test::whole(mesh);
  const auto operators = make_operators(subdomain, 1180);
  double mass = 0;
  for (const double m : operators.node_mass) mass += m;
  EXPECT_NEAR(mass, 1180 * 0.005 * 0.01 * 0.02, 1e-13 * mass);
}

class Forces : public ::testing::Test {
protected:
  Forces()
      : mesh_(disturbed_box()),
        subdomain_(test::whole(mesh_)),
        operators_(make_operators(subdomain_, 1180)),
        elasticity_(IsotropicElasticity(test::epoxy())),
        residual_stiffness_(operators_, elasticity_),
        force_(operators_, residual_stiffness_) {}

  std::vector<double> displacement_of(auto&& function) const {
    std::vector<double> u;
    for (const auto& p : subdomain_.nodes) {
      for (const double value : function(p)) u.push_back(value);
    }
    return u;
  }
  std::vector<double> force_of(const std::vector<double>& u) const {
    std::vector<double> f(u.size());
    force_.evaluate(u, f);
    return f;
  }

  geometry::Realization mesh_;
  geometry::Subdomain subdomain_;
  PdsOperators operators_;
  ElasticityField elasticity_;
  ResidualStiffness residual_stiffness_;
  InternalForce force_;
};

TEST_F(Forces, ConstantStrainIsReproduced) {
  const auto u = displacement_of([](const Point& p) {
    return Vector{1e-3 * p[0] + 2e-3 * p[1] - 1e-3 * p[2], 3e-3 * p[1] + 1e-3 * p[2],
                  -2e-3 * p[2] + 4e-3 * p[0]};
  });
  const Symmetric expected{1e-3, 3e-3, -2e-3, 0.5e-3, 1.5e-3, 1e-3};
  double worst = 0;
  for (const auto& t : operators_.tetrahedra) {
    const Symmetric eps = strain(t, u);
    for (std::size_t i = 0; i < 6; ++i) worst = std::max(worst, std::abs(eps[i] - expected[i]));
  }
  std::printf("largest strain error of the patch test: %.2e of 4e-3\n", worst);
  EXPECT_LT(worst, 1e-15);
  // Interior nodes are in equilibrium under constant stress.
  const auto f = force_of(u);
  for (std::size_t n = 0; n < subdomain_.nodes.size(); ++n) {
    const auto& p = subdomain_.nodes[n];
    const bool interior = p[0] > 0 && p[0] < 0.005 && p[1] > 0 && p[1] < 0.01 && p[2] > 0 && p[2] < 0.02;
    for (std::size_t i = 0; interior && i < 3; ++i) EXPECT_NEAR(f[3 * n + i], 0, 1e-11);
  }
}

TEST_F(Forces, RigidMotionsGiveNoForce) {
  const auto u = displacement_of([](const Point& p) {
    return Vector{1e-3 - 2e-3 * p[1] + 3e-3 * p[2], -2e-3 + 2e-3 * p[0] - 1e-3 * p[2],
                  5e-4 - 3e-3 * p[0] + 1e-3 * p[1]};
  });
  double worst = 0;
  for (const double f : force_of(u)) worst = std::max(worst, std::abs(f));
  std::printf("largest force of a rigid motion: %.2e N\n", worst);
  EXPECT_LT(worst, 1e-8);
}

TEST_F(Forces, TotalForceAndMomentVanishForAnyDisplacementAndBrokenSet) {
  RandomStream stream(3, 0, "forces");
  for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); t += 5) residual_stiffness_.release(t, all_edges);
  const auto u = displacement_of([&](const Point&) {
    return Vector{stream.uniform(-1e-5, 1e-5), stream.uniform(-1e-5, 1e-5), stream.uniform(-1e-5, 1e-5)};
  });
  const auto f = force_of(u);
  Vector total{}, moment{};
  double largest = 0;
  for (std::size_t n = 0; n < subdomain_.nodes.size(); ++n) {
    const Vector fn{f[3 * n], f[3 * n + 1], f[3 * n + 2]};
    const Vector m = cross(subdomain_.nodes[n], fn);
    for (std::size_t i = 0; i < 3; ++i) {
      total[i] += fn[i];
      moment[i] += m[i];
      largest = std::max(largest, std::abs(fn[i]));
    }
  }
  std::printf("forces up to %.3g N; total %.2e N, moment %.2e N m\n", largest, total[0], moment[0]);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(total[i], 0, 1e-12 * largest);
    EXPECT_NEAR(moment[i], 0, 1e-13 * largest);
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::mechanics
