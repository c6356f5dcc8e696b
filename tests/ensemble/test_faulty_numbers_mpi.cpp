// SPDX-License-Identifier: GPL-3.0-or-later
// Non-finite numbers on one rank: no sum loses them, no rank deadlocks, no solver accepts them as an
// equilibrium.
#include "common/index.h"
#include "dynamics/stable_step.h"
#include "mechanics/conditions.h"
#include "mechanics/static_solver.h"
#include "parallel/agreement.h"
#include "parallel/exact_sum.h"
#include "parallel/reproducible.h"

#include "mechanics/conjugate_gradients.h"
#include "support/box_mesh.h"
#include "support/group.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace crackle {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

class FaultyNumbers : public testing::Test {
protected:
  bool is_last() const { return world_.rank() == world_.size() - 1; }

  /// Twenty numbers on every rank, including `fault` on the last one.
  std::vector<double> numbers(double fault, std::size_t place) const {
    std::vector<double> values(20);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = static_cast<double>(i) - 7.5 + 100 * world_.rank();
    if (is_last()) values[place] = fault;
    return values;
  }

  parallel::Communicator world_{test::group()};
  std::vector<double> ones_ = std::vector<double>(20, 1.0);
  geometry::Realization mesh_ = test::make_box({.size = {0.004, 0.006, 0.02}, .cells = {3, 4, 8}});
  geometry::Subdomain part_ =
      geometry::split(mesh_, geometry::partition(mesh_, world_.size()))[index(world_.rank())];
};

TEST_F(FaultyNumbers, AreInDotProducts) {
  for (const std::size_t place : {0U, 7U, 19U}) {
    EXPECT_TRUE(std::isnan(parallel::reproducible_dot(world_.get(), numbers(nan, place), ones_))) << place;
    EXPECT_TRUE(std::isnan(parallel::reproducible_dot(world_.get(), numbers(-nan, place), ones_))) << place;
    EXPECT_EQ(parallel::reproducible_dot(world_.get(), numbers(-infinity, place), ones_), infinity) << place;
  }
  auto values = numbers(nan, 3);
  if (is_last()) values[4] = infinity;
  EXPECT_TRUE(std::isnan(parallel::reproducible_dot(world_.get(), values, ones_)));
  double expected = 0;
  for (int rank = 0; rank < world_.size(); ++rank) expected += 20 * (2 + 100 * rank);
  const double last = static_cast<double>(3) - 7.5 + 100 * (world_.size() - 1);
  EXPECT_EQ(parallel::reproducible_dot(world_.get(), numbers(last, 3), ones_), expected);
}

TEST_F(FaultyNumbers, EndExactSumsOnAllRanks) {
  for (const double fault : {nan, infinity}) {
    EXPECT_THROW(parallel::exact_sum(world_, numbers(fault, 5)), parallel::AgreedError);
    EXPECT_THROW(parallel::exact_dot(world_, numbers(fault, 5), ones_), parallel::AgreedError);
    EXPECT_THROW(parallel::exact_sums(world_, std::vector{ones_, numbers(fault, 5)}), parallel::AgreedError);
  }
  const auto finite = numbers(1, 5);
  EXPECT_THAT(
      parallel::exact_sums(world_, std::vector{finite, {}, ones_}),
      testing::ElementsAre(parallel::exact_sum(world_, finite), 0, parallel::exact_sum(world_, ones_)));
  EXPECT_THAT(parallel::exact_sums(world_, {}), testing::IsEmpty());
  EXPECT_EQ(parallel::exact_dot(world_, finite, ones_), parallel::exact_sum(world_, finite));
}

TEST_F(FaultyNumbers, InTheMassEndTheSearchForTheStableStep) {
  auto operators = mechanics::make_operators(part_, test::epoxy().density);
  const mechanics::ElasticityField elasticity{mechanics::IsotropicElasticity(test::epoxy())};
  const mechanics::ResidualStiffness intact(operators, elasticity);
  const mechanics::InternalForce force(operators, intact);
  if (is_last()) operators.node_mass[0] = nan;
  EXPECT_THROW(dynamics::largest_frequency(world_, part_, operators, force), parallel::AgreedError);
}

TEST_F(FaultyNumbers, InTheMeshEndTheLoads) {
  input::Parameters parameters;
  parameters.boundaries.push_back(test::boundary(Face::x_min, BoundaryKind::traction, {}, {1, 0, 0}));
  // Far away, so that the triangle is within every region, and its area is not finite.
  if (is_last()) {
    for (const auto& triangle : part_.boundary)
      for (const auto node : triangle.nodes) part_.nodes[index(node)][1] *= 1e200;
  }
  EXPECT_THROW(mechanics::make_boundary_loads(world_, parameters, part_), parallel::AgreedError);
}

TEST_F(FaultyNumbers, AreNoEquilibrium) {
  const auto material = test::epoxy();
  const mechanics::ElasticityField elasticity{mechanics::IsotropicElasticity(material)};
  const auto operators = mechanics::make_operators(part_, material.density);
  const mechanics::ResidualStiffness intact(operators, elasticity);
  const auto edges = mechanics::make_edges(part_);
  mechanics::HeldComponents held(3 * part_.nodes.size(), 0);
  for (std::size_t n = 0; n < part_.nodes.size(); ++n)
    if (part_.nodes[n][2] == 0) held[3 * n] = held[3 * n + 1] = held[3 * n + 2] = 1;
  mechanics::StaticSolver solver(world_, part_, operators, elasticity, edges, intact, held);
  const auto n_owned = static_cast<std::size_t>(part_.layout.n_owned);
  std::size_t free = 0;
  while (free < 3 * n_owned && held[free] != 0) ++free;
  const std::vector<double> good(3 * n_owned, 1.0);

  for (const double fault : {nan, infinity}) {
    auto force = good;
    if (is_last() && free < force.size()) force[free] = fault;
    parallel::NodeField displacement(world_, part_.layout);
    std::string message;
    try {
      solver.solve(force, displacement);
    } catch (const mechanics::NoEquilibrium& error) {
      message = error.what();
    }
    EXPECT_NE(message, "") << "a force of " << fault;
    if (world_.is_root()) std::printf("force %g: %s\n", fault, message.c_str());
  }
  // A NaN guess, as left by a solver that has diverged.
  parallel::NodeField displacement(world_, part_.layout);
  if (is_last() && free < 3 * n_owned) displacement.owned()[free] = nan;
  EXPECT_THROW(solver.solve(good, displacement), mechanics::NoEquilibrium);
  // The solver still works afterwards.
  parallel::NodeField fresh(world_, part_.layout);
  EXPECT_GT(solver.solve(good, fresh), 0);
}

/// A multiple of the identity, which needs no preconditioner.
struct Diagonal {
  const parallel::Communicator& group;
  float value;
  std::vector<float> values = std::vector<float>(20);

  double dot(std::span<const float> a, std::span<const float> b) const {
    return parallel::reproducible_dot(group.get(), a, b);
  }
  std::span<float> direction() { return values; }
  double multiply(std::span<float> image) const {
    for (std::size_t i = 0; i < image.size(); ++i) image[i] = value * values[i];
    return dot(values, image);
  }
  double precondition(std::span<const float> residual, std::span<float> result) const {
    std::ranges::copy(residual, result.begin());
    return dot(residual, result);
  }
};

/// Conjugate gradients stop at NaN, consistently on all ranks, and at a matrix that is not definite.
TEST_F(FaultyNumbers, ConjugateGradientsEnd) {
  std::vector<float> solution(20);
  const auto solve = [&](float value, float last) {
    Diagonal system{world_, value};
    mechanics::ConjugateGradients<Diagonal> gradients(world_, system);
    std::vector<float> right(20, 1.0F);
    if (is_last()) right.back() = last;
    return gradients.solve(right, solution, 1e-12, 10);
  };
  const auto solved = solve(4, 1);
  EXPECT_TRUE(solved.has_converged);
  EXPECT_EQ(solved.n_iterations, 1);
  for (const float x : solution) EXPECT_EQ(x, 0.25F);
  EXPECT_FALSE(solve(-4, 1).has_converged);
  EXPECT_FALSE(solve(4, std::numeric_limits<float>::quiet_NaN()).has_converged);
  EXPECT_FALSE(solve(4, std::numeric_limits<float>::infinity()).has_converged);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle
