// SPDX-License-Identifier: GPL-3.0-or-later
// The stress averaged over balls.
#include "fracture/equivalent_stress.h"
#include "fracture/stress_average.h"
#include "geometry/point.h"

#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace crackle::fracture {
namespace CRACKLE_TEST_FILE {

using mechanics::Symmetric;

constexpr double strength = 35e6, length = 2.5e-3;

/// A block of 8 x 8 x 8 mm in cells of 1 mm, with varying strengths.
class Block : public testing::Test {
protected:
  std::vector<double> make_strengths() const {
    std::vector<double> strengths;
    for (std::size_t t = 0; t < mesh_.tetrahedra.size(); ++t)
      strengths.push_back(strength * (1 + 0.1 * static_cast<double>(t % 5)));
    return strengths;
  }
  geometry::Point centroid(std::int32_t t) const {
    return geometry::centroid(mesh_.nodes, mesh_.tetrahedra[index(t)]);
  }
  std::int32_t nearest(const geometry::Point& place) const {
    std::int32_t best = 0;
    for (std::int32_t t = 1; t < subdomain_.n_tetrahedra(); ++t)
      if (norm(centroid(t) - place) < norm(centroid(best) - place)) best = t;
    return best;
  }
  double sum_of_shares(std::int32_t centre) {
    double sum = 0;
    for (const auto& [t, weight] : average_.ball(centre)) sum += weight * strengths_[index(t)];
    return sum;
  }
  /// Breaks a layer of cells, z from 4 to 5 mm, up to y.
  void cut(double y) {
    for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); ++t) {
      const auto p = centroid(t);
      if (p[2] > 4e-3 && p[2] < 5e-3 && p[1] < y && !body_.is_broken(t)) body_.release(t, {}, 0, 0);
    }
  }

  geometry::Realization mesh_ =
      test::make_box({.size = {8e-3, 8e-3, 8e-3}, .cells = {8, 8, 8}, .disturbance = 0.2});
  geometry::Subdomain subdomain_ = test::whole(mesh_);
  BreakableBody body_{subdomain_, test::epoxy()};
  std::vector<double> strengths_ = make_strengths();
  StressAverage average_{body_, strengths_, length};
};

TEST_F(Block, AveragesOverTheStrengthWithTheBellOfTheDistance) {
  const auto centre = nearest({4e-3, 4e-3, 4e-3});
  const auto ball = average_.ball(centre);
  const auto in_reach = [&](std::int32_t t) { return norm(centroid(t) - centroid(centre)) < length; };
  std::int64_t n_in_reach = 0;
  for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); ++t) n_in_reach += in_reach(t);
  EXPECT_EQ(std::ssize(ball), n_in_reach);
  EXPECT_NEAR(sum_of_shares(centre), 1, 1e-14);
  const auto [first, first_weight] = ball.front();
  EXPECT_EQ(first, centre);
  for (const auto& [t, weight] : ball) {
    const double r = norm(centroid(t) - centroid(centre)) / length;
    const double volumes =
        body_.operators().tetrahedra[index(t)].volume / body_.operators().tetrahedra[index(centre)].volume;
    EXPECT_NEAR(weight * strengths_[index(t)] / (first_weight * strengths_[index(centre)]),
                volumes * (1 - r * r) * (1 - r * r), 1e-12);
  }
}

/// In the centre of the block the average of a linear stress is the local stress, and that of a stress
/// growing as x^2 is larger by l^2 / 9: the second moment of the bell function, 1/3 of int r^4 w / int r^2 w.
TEST_F(Block, OfALinearStressIsTheStressThere) {
  std::fill(strengths_.begin(), strengths_.end(), 1.0);
  StressAverage average(body_, strengths_, length);
  const auto centre = nearest({4e-3, 4e-3, 4e-3});
  const auto linear = average(centre, [&](std::int32_t t) {
    const auto p = centroid(t);
    return Symmetric{p[0] / 8e-3, p[1] / 8e-3, p[2] / 8e-3, 1, 0, 0};
  });
  const auto middle = centroid(centre);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(linear[i], middle[i] / 8e-3, 0.01);
  EXPECT_NEAR(linear[3], 1, 1e-14);
  const auto square = average(centre, [&](std::int32_t t) {
    const auto p = centroid(t) - middle;
    return Symmetric{p[0] * p[0], p[1] * p[1], p[2] * p[2], 0, 0, 0};
  });
  const double trace = (square[0] + square[1] + square[2]) / (length * length);
  std::printf("mean square distance over l^2: %.4f, exact for small tetrahedra %.4f\n", trace, 1.0 / 3);
  EXPECT_NEAR(trace, 1.0 / 3, 0.02);
}

TEST_F(Block, SeesNothingAcrossACrack) {
  cut(1);
  const auto below = nearest({4e-3, 4e-3, 3.5e-3});
  bool sees_crack_side = false;
  for (const auto& [t, weight] : average_.ball(below)) {
    EXPECT_FALSE(body_.is_broken(t));
    EXPECT_LT(centroid(t)[2], 4e-3);
    sees_crack_side = sees_crack_side || centroid(t)[2] > 3.5e-3;
  }
  EXPECT_TRUE(sees_crack_side);
  // The boundary of the crack is in the ball, and stress-free.
  std::printf("beside a crack the unbroken have %.3f of the weight\n", sum_of_shares(below));
  EXPECT_LT(sum_of_shares(below), 0.95);
  EXPECT_GT(sum_of_shares(below), 0.5);
}

/// A crack that ends in the ball is bypassed around its front, within the ball.
TEST_F(Block, LooksRoundTheFrontOfACrack) {
  cut(4e-3);
  const auto below = nearest({4e-3, 3.8e-3, 3.7e-3});
  bool sees_other_side = false;
  for (const auto& [t, weight] : average_.ball(below))
    sees_other_side = sees_other_side || (centroid(t)[2] > 5e-3 && centroid(t)[1] > 4e-3);
  EXPECT_TRUE(sees_other_side);
}

/// No cached ball may be used after a break in it.
TEST_F(Block, IsThatOfTheBodyAsItIsNow) {
  std::vector<std::int32_t> centres;
  for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); t += 7) centres.push_back(t);
  for (const double front : {0.0, 2e-3, 4e-3, 4.5e-3}) {
    cut(front);
    StressAverage fresh(body_, strengths_, length);
    for (const auto centre : centres) {
      if (body_.is_broken(centre)) continue;
      const auto kept = average_.ball(centre), now = fresh.ball(centre);
      EXPECT_TRUE(std::ranges::equal(kept, now, [](const auto& a, const auto& b) {
        return a.tetrahedron == b.tetrahedron && a.weight == b.weight;
      }));
      EXPECT_EQ(average_.node_shares(centre).gradients, fresh.node_shares(centre).gradients);
    }
  }
}

TEST_F(Block, IsTheSameByNodesWhereCracked) {
  cut(4e-3);
  std::vector<double> u;
  for (std::size_t i = 0; i < 3 * subdomain_.nodes.size(); ++i)
    u.push_back(1e-6 * static_cast<double>(i * 7919 % 101));
  const auto at = [&](std::int32_t node) {
    return Vector{u[index(node, 0)], u[index(node, 1)], u[index(node, 2)]};
  };
  for (std::int32_t centre = 0; centre < subdomain_.n_tetrahedra(); centre += 7) {
    if (body_.is_broken(centre)) continue;
    const Symmetric by_tetrahedra = average_(centre, [&](std::int32_t t) { return body_.stress(t, u); });
    const auto& [nodes, gradients] = average_.node_shares(centre);
    Symmetric strain{};
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const auto product = mechanics::symmetric_product(gradients[n], at(nodes[n]) - at(nodes.front()));
      for (std::size_t i = 0; i < strain.size(); ++i) strain[i] += product[i];
    }
    const Symmetric by_nodes = body_.intact_stress(centre, strain);
    for (std::size_t i = 0; i < strain.size(); ++i) EXPECT_NEAR(by_nodes[i], by_tetrahedra[i], 1e-11);
  }
}

TEST_F(Block, BreaksTheMostStressedForItsStrength) {
  const LargestPrincipalStress value;
  const auto centre = nearest({4e-3, 4e-3, 4e-3});
  const auto stress = [&](std::int32_t t) {
    const double s = 1e6 * (20 + static_cast<double>(t * 7919 % 101) / 10);
    return Symmetric{0.2 * s, s, 0.3 * s, 0.1 * s, 0, 0};
  };
  std::int32_t most = -1;
  double largest = 0;
  for (const auto& [t, weight] : average_.ball(centre)) {
    const double load = value(stress(t)) / strengths_[index(t)];
    if (load < largest || (load == largest && t > most)) continue;
    largest = load;
    most = t;
  }
  EXPECT_EQ(average_.most_stressed(centre, value, stress), most);
  // The bound on which the breaking check relies.
  EXPECT_LE(value(average_(centre, stress)), largest);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::fracture
