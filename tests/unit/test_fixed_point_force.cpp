// SPDX-License-Identifier: GPL-3.0-or-later
// The fast force, edge by edge in integers, against the plain loop over tetrahedra.
#include "common/index.h"
#include "common/instruction_set.h"
#include "fracture/breakable_body.h"

#include "mechanics/fixed_point_force.h"
#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

namespace crackle::mechanics {
namespace CRACKLE_TEST_FILE {

/// A perturbed block with some broken tetrahedra, under small strain and far from its initial position.
class FixedPointForceTest : public ::testing::Test {
protected:
  FixedPointForceTest()
      : mesh_(test::make_box({.size = {0.005, 0.008, 0.012}, .cells = {5, 8, 12}, .disturbance = 0.25})),
        subdomain_(test::whole(mesh_)),
        body_(subdomain_, test::epoxy()) {}

  void break_every(std::int32_t interval) {
    for (std::int32_t t = 1; t < subdomain_.n_tetrahedra(); t += interval) body_.release(t, {}, 0, 0);
  }

  std::vector<double> random_displacement(double shift) const {
    std::vector<double> u;
    for (std::size_t n = 0; n < subdomain_.nodes.size(); ++n) {
      RandomStream stream =
          RandomStream(3, 0, "state").substream(static_cast<std::uint64_t>(subdomain_.layout.number[n]));
      for (std::size_t i = 0; i < 3; ++i) u.push_back(shift + 1e-5 * stream.uniform(-1, 1));
    }
    return u;
  }

  std::vector<double> reference(const std::vector<double>& u) const {
    std::vector<double> f(u.size());
    body_.force().evaluate(u, f);
    return f;
  }

  template <class Real>
  FixedPointForce<Real> make(const geometry::Subdomain& subdomain, const fracture::BreakableBody& body,
                             InstructionSet set = best_instruction_set(),
                             std::int32_t pair_reach = FixedPointForce<Real>::largest_reach) const {
    const std::vector<double> no_mass(static_cast<std::size_t>(subdomain.layout.n_owned), 1.0);
    const auto scale = fixed_point_scale<Real>({.stretch = 1e-4, .velocity = 1, .force = 4000});
    return FixedPointForce<Real>(subdomain, body.operators(), body.elasticity(), body.edges(),
                                 body.residual_stiffness(), no_mass, scale, set, false, pair_reach);
  }

  template <class Real>
  static void set_displacement(FixedPointForce<Real>& force, const std::vector<double>& u) {
    const auto nodes = force.nodes();
    for (std::size_t i = 0; i < u.size(); ++i)
      nodes[i / 3].displacement[i % 3] =
          static_cast<kernels::Integer<Real>>(std::llrint(u[i] / force.scale().displacement));
  }

  template <class Real>
  static std::vector<double> evaluate(FixedPointForce<Real>& force) {
    force.evaluate();
    std::vector<double> f;
    for (const auto& node : force.nodes())
      for (std::size_t i = 0; i < 3; ++i)
        f.push_back(force.scale().force * static_cast<double>(node.force[i]));
    return f;
  }

  static double relative_error(const std::vector<double>& f, const std::vector<double>& exact) {
    double worst = 0, largest = 0;
    for (std::size_t i = 0; i < f.size(); ++i) {
      worst = std::max(worst, std::abs(f[i] - exact[i]));
      largest = std::max(largest, std::abs(exact[i]));
    }
    return worst / largest;
  }

  geometry::Realization mesh_;
  geometry::Subdomain subdomain_;
  fracture::BreakableBody body_;
};

template <class Real>
constexpr const char* name = sizeof(Real) == 4 ? "mixed" : "double";

TEST_F(FixedPointForceTest, AgreesWithThePlainLoopToTheFormatsRounding) {
  break_every(7);
  const auto check = [&]<class Real>(Real, double bound) {
    for (const double shift : {0.0, 1e-3}) {
      const auto u = random_displacement(shift);
      auto force = make<Real>(subdomain_, body_);
      set_displacement(force, u);
      const double error = relative_error(evaluate(force), reference(u));
      std::printf("%s, rigid shift %.0f mm: largest error %.1e of the largest force\n", name<Real>,
                  1e3 * shift, error);
      EXPECT_LT(error, bound);
      EXPECT_FALSE(force.has_overflown());
    }
  };
  check(float{}, 2e-6);
  check(double{}, 1e-9);
}

TEST_F(FixedPointForceTest, RigidRotationGivesNoForce) {
  break_every(5);
  std::vector<double> u;
  for (const auto& p : subdomain_.nodes)
    u.insert(u.end(), {1e-3 * (2 * p[1] - p[2]), 1e-3 * (-2 * p[0] + 3 * p[2]), 1e-3 * (p[0] - 3 * p[1])});
  auto force = make<float>(subdomain_, body_);
  set_displacement(force, u);
  const auto f = evaluate(force);
  const double largest = std::abs(*std::ranges::max_element(f, {}, [](double x) { return std::abs(x); }));
  const auto random = reference(random_displacement(0));
  const double scale = std::abs(*std::ranges::max_element(random, {}, [](double x) { return std::abs(x); }));
  std::printf("rotation of 0.004: largest force %.1e N; random strain gives %.1e N\n", largest, scale);
  EXPECT_LT(largest, 1e-5 * scale);
}

TEST_F(FixedPointForceTest, AllInstructionSetsGiveTheSameBits) {
  break_every(7);
  const auto u = random_displacement(1e-4);
  const auto check = [&]<class Real>(Real) {
    std::vector<double> first;
    for (const auto set : available_instruction_sets()) {
      auto force = make<Real>(subdomain_, body_, set);
      set_displacement(force, u);
      const auto f = evaluate(force);
      std::printf("%s, %s: %zu forces\n", name<Real>, std::string(to_string(set)).c_str(), f.size());
      if (first.empty()) first = f;
      EXPECT_EQ(f, first);
    }
  };
  check(float{});
  check(double{});
}

TEST_F(FixedPointForceTest, RenumberedNodesGetTheSameBits) {
  break_every(7);
  auto renumbered = subdomain_;
  std::vector<std::int32_t> place(subdomain_.nodes.size());  // new number of each node
  std::iota(place.begin(), place.end(), 0);
  RandomStream stream(5, 0, "renumbering");
  for (std::size_t i = place.size() - 1; i > 0; --i)
    std::swap(
        place[i],
        place[std::min(i, static_cast<std::size_t>(stream.uniform(0, 1) * static_cast<double>(i + 1)))]);
  for (std::size_t n = 0; n < place.size(); ++n) {
    renumbered.nodes[index(place[n])] = subdomain_.nodes[n];
    renumbered.layout.number[index(place[n])] = subdomain_.layout.number[n];
  }
  for (auto& t : renumbered.tetrahedra)
    for (auto& node : t) node = place[index(node)];
  for (auto& triangle : renumbered.boundary)
    for (auto& node : triangle.nodes) node = place[index(node)];
  fracture::BreakableBody body(renumbered, test::epoxy());
  for (const auto t : body_.broken_tetrahedra()) body.release(t, {}, 0, 0);

  const auto u = random_displacement(0);
  std::vector<double> moved(u.size());
  for (std::size_t i = 0; i < u.size(); ++i) moved[3 * index(place[i / 3]) + i % 3] = u[i];
  auto force = make<float>(subdomain_, body_);
  auto other = make<float>(renumbered, body);
  set_displacement(force, u);
  set_displacement(other, moved);
  const auto f = evaluate(force), g = evaluate(other);
  for (std::size_t i = 0; i < f.size(); ++i)
    ASSERT_EQ(f[i], g[3 * index(place[i / 3]) + i % 3]) << "component " << i;
}

TEST_F(FixedPointForceTest, UpdateAfterBreaksEqualsARebuild) {
  break_every(50);
  const auto u = random_displacement(0);
  const auto check = [&]<class Real>(Real) {
    auto force = make<Real>(subdomain_, body_);
    set_displacement(force, u);
    evaluate(force);
    std::vector<std::int32_t> broken;
    for (std::int32_t t = 3; t < subdomain_.n_tetrahedra(); t += sizeof(Real) == 4 ? 11 : 13) {
      if (body_.is_broken(t)) continue;
      body_.release(t, {}, 0, 0);
      broken.push_back(t);
      if (broken.size() % 5 == 0) {
        force.update(broken, true);
        broken.clear();
      }
    }
    force.update(broken, true);
    std::vector<double> corrected;
    for (const auto& node : force.nodes())
      for (std::size_t i = 0; i < 3; ++i)
        corrected.push_back(force.scale().force * static_cast<double>(node.force[i]));
    auto rebuilt = make<Real>(subdomain_, body_);
    set_displacement(rebuilt, u);
    EXPECT_EQ(evaluate(force), evaluate(rebuilt)) << name<Real> << ": coefficients";
    EXPECT_EQ(corrected, evaluate(rebuilt)) << name<Real> << ": corrected forces";
  };
  check(float{});
  check(double{});
}

TEST_F(FixedPointForceTest, EdgesThatReachTooFarForAPairGetTheSameBits) {
  break_every(50);
  const auto u = random_displacement(0);
  const auto check = [&]<class Real>(Real) {
    auto force = make<Real>(subdomain_, body_);
    set_displacement(force, u);
    const auto f = evaluate(force);
    for (const std::int32_t reach : {0, 5, 40}) {
      auto other = make<Real>(subdomain_, body_, best_instruction_set(), reach);
      set_displacement(other, u);
      EXPECT_EQ(f, evaluate(other)) << name<Real> << ", reach " << reach;
      EXPECT_GT(other.bytes_per_sweep(), force.bytes_per_sweep());
    }
  };
  check(float{});
  check(double{});
}

TEST_F(FixedPointForceTest, OwnersHaveGroupsOfFourWithLittlePadding) {
  const auto force = make<float>(subdomain_, body_);
  const double padding = force.padding();
  std::printf("padding: %.2f %% of the edges in pairs\n", 100 * padding);
  // The small block has few inner edges per node.
  EXPECT_LT(padding, 0.15);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::mechanics
