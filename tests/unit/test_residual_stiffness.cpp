// SPDX-License-Identifier: GPL-3.0-or-later
// Residual stiffness with release by facets: stress-free in rigid rotations, symmetric and positive
// semi-definite, never more energy, and zero across a through crack.
#include "common/index.h"
#include "dynamics/energy_account.h"
#include "fracture/connectivity.h"
#include "parallel/exact_sum.h"

#include "mechanics/fixed_point_force.h"
#include "support/box_mesh.h"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

namespace crackle::mechanics {
namespace CRACKLE_TEST_FILE {

constexpr std::array<geometry::Point, 4> some_corners{
    {{0, 0, 0}, {1e-3, 1e-4, 0}, {2e-4, 9e-4, -1e-4}, {3e-4, 2e-4, 8e-4}}};

TetrahedronOperator some_tetrahedron() {
  return tetrahedron_operator({0, 1, 2, 3}, some_corners);
}

Symmetric random_strain(RandomStream& stream) {
  Symmetric strain{};
  for (double& e : strain) e = stream.uniform(-1e-3, 1e-3);
  return strain;
}

TEST(EdgeStiffness, IsTheMaterialsWhenNothingIsReleased) {
  const IsotropicElasticity elasticity(test::epoxy());
  const EdgeStiffness intact = edge_stiffness(some_tetrahedron(), elasticity, no_edge);
  RandomStream stream(1, 0, "strain");
  double worst = 0;
  for (int i = 0; i < 20; ++i) {
    const Symmetric strain = random_strain(stream);
    const Symmetric expected = elasticity(strain), found = intact.stress(strain);
    for (std::size_t c = 0; c < 6; ++c) worst = std::max(worst, std::abs(found[c] - expected[c]));
  }
  std::printf("largest difference of stress: %.1e Pa of some 1e7 Pa\n", worst);
  EXPECT_LT(worst, 1e-5);
}

TEST(EdgeStiffness, IsPositiveSemiDefiniteWithTheRankOfItsKeptEdges) {
  const IsotropicElasticity elasticity(test::epoxy());
  const TetrahedronOperator t = some_tetrahedron();
  double lowest = 0;
  for (unsigned set = 0; set < 64; ++set) {
    const EdgeStiffness stiffness = edge_stiffness(t, elasticity, static_cast<EdgeSet>(set));
    Eigen::Matrix<double, 12, 12> k;
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b < 4; ++b) {
        const Matrix block = stiffness.coupling(a, b);
        for (std::size_t i = 0; i < 3; ++i)
          for (std::size_t j = 0; j < 3; ++j)
            k(static_cast<Eigen::Index>(3 * a + i), static_cast<Eigen::Index>(3 * b + j)) = block[i][j];
      }
    }
    EXPECT_LT((k - k.transpose()).norm(), 1e-12 * (1 + k.norm()));
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(k);
    const double scale = std::abs(edge_stiffness(t, elasticity, no_edge).coupling(0, 0)[0][0]);
    lowest = std::min(lowest, modes.eigenvalues()[0] / scale);
    EXPECT_EQ((modes.eigenvalues().array() > 1e-9 * scale).count(), 6 - std::popcount(set)) << "set " << set;
  }
  std::printf("64 sets of released edges: lowest eigenvalue %.1e of the stiffness\n", lowest);
  EXPECT_GT(lowest, -1e-12);
}

TEST(EdgeStiffness, OfEveryReleaseLowersTheEnergy) {
  const IsotropicElasticity elasticity(test::epoxy());
  const TetrahedronOperator t = some_tetrahedron();
  RandomStream stream(2, 0, "strain");
  double highest = -1;
  for (int i = 0; i < 20; ++i) {
    const Symmetric strain = random_strain(stream);
    const auto energy = [&](unsigned set) {
      return contract(edge_stiffness(t, elasticity, static_cast<EdgeSet>(set)).stress(strain), strain);
    };
    const double whole = energy(0);
    for (unsigned set = 0; set < 64; ++set)
      for (unsigned k = 0; k < 6; ++k)
        highest = std::max(highest, (energy(set | (1U << k)) - energy(set)) / whole);
  }
  std::printf("largest gain of energy by a release: %.1e of the whole\n", highest);
  EXPECT_LT(highest, 1e-12);
}

TEST(EdgeStiffness, OfAMembraneHasNoTractionOnItsPlane) {
  const IsotropicElasticity elasticity(test::epoxy());
  const TetrahedronOperator t = some_tetrahedron();
  RandomStream stream(3, 0, "strain");
  for (int corner = 0; corner < 4; ++corner) {
    const EdgeStiffness membrane = edge_stiffness(t, elasticity, fracture::crossed_edges(corner));
    const Symmetric sigma = membrane.stress(random_strain(stream));
    const Vector traction = apply(sigma, t.gradient[index(corner)]);
    EXPECT_LT(std::sqrt(dot(traction, traction)), 1e-9 * std::sqrt(contract(sigma, sigma)) * 1e3);
    EXPECT_GT(std::sqrt(contract(sigma, sigma)), 1e5);
  }
}

/// Release by facets that keeps a share of the stiffness by the time since the break.
class InTime final : public fracture::FacetRelease {
public:
  explicit InTime(std::function<double(double)> share)
      : fracture::FacetRelease(Course()), share_(std::move(share)) {}
  double remaining(std::int32_t, double since_break) const override { return share_(since_break); }

private:
  std::function<double(double)> share_;
};

/// A block with facets opened at random.
class FacetBody : public ::testing::Test {
protected:
  FacetBody()
      : mesh_(test::make_box({.size = {0.004, 0.006, 0.008}, .cells = {4, 6, 8}, .disturbance = 0.2})),
        subdomain_(test::whole(mesh_)),
        body_(subdomain_, test::epoxy(), fracture::make_release({.release = input::Release::facet})) {}

  std::vector<double> displacement(auto&& function) const {
    std::vector<double> u;
    for (const auto& p : subdomain_.nodes) {
      const Vector at = function(p);
      u.insert(u.end(), at.begin(), at.end());
    }
    return u;
  }
  std::vector<double> random_displacement() const {
    RandomStream stream(5, 0, "displacement");
    return displacement([&](const auto&) {
      return Vector{stream.uniform(-1e-6, 1e-6), stream.uniform(-1e-6, 1e-6), stream.uniform(-1e-6, 1e-6)};
    });
  }
  void break_where(auto&& chosen, const std::vector<double>& u) {
    for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); ++t)
      if (chosen(t)) body_.release(t, body_.strain(t, u), 0, 0);
    body_.release_bridges(self_, 0, 0, [&](std::int32_t t) { return body_.strain(t, u); });
  }
  double total(const std::vector<double>& values) const { return parallel::exact_sum(self_, values); }

  parallel::Communicator self_{MPI_COMM_SELF};
  geometry::Realization mesh_;
  geometry::Subdomain subdomain_;
  fracture::BreakableBody body_;
};

double largest(const std::vector<double>& values) {
  double result = 0;
  for (const double v : values) result = std::max(result, std::abs(v));
  return result;
}

TEST_F(FacetBody, IsFreeOfForceInRigidRotationsAndTheFastForceIsThePlainOne) {
  const auto u = random_displacement();
  break_where([](std::int32_t t) { return t % 3 == 0; }, u);
  std::vector<double> f(u.size()), turned(u.size());
  body_.force().evaluate(u, f);
  body_.force().evaluate(
      displacement([](const auto& p) {
        return Vector{1e-2 * (2 * p[1] - p[2]), 1e-2 * (-2 * p[0] + 3 * p[2]), 1e-2 * (p[0] - 3 * p[1])};
      }),
      turned);
  std::printf("rotation of 0.04: largest force %.1e N; random strain gives %.1e N\n", largest(turned),
              largest(f));
  EXPECT_LT(largest(turned), 1e-9 * largest(f));

  const std::vector<double> no_mass(subdomain_.nodes.size(), 1.0);
  FixedPointForce<double> fast(
      subdomain_, body_.operators(), body_.elasticity(), body_.edges(), body_.residual_stiffness(), no_mass,
      fixed_point_scale<double>({.stretch = 1e-4, .velocity = 1, .force = 4000}), best_instruction_set());
  for (std::size_t i = 0; i < u.size(); ++i)
    fast.nodes()[i / 3].displacement[i % 3] = std::llrint(u[i] / fast.scale().displacement);
  for (std::int32_t b = 0; b < fast.n_blocks(); ++b) fast.add_block(b);
  double worst = 0;
  for (std::size_t i = 0; i < u.size(); ++i)
    worst = std::max(
        worst, std::abs(fast.scale().force * static_cast<double>(fast.nodes()[i / 3].force[i % 3]) - f[i]));
  std::printf("fast force: largest difference %.1e of the largest\n", worst / largest(f));
  EXPECT_LT(worst, 1e-9 * largest(f));
}

TEST_F(FacetBody, EnergyLostIsEnergyReleased) {
  const auto u = random_displacement();
  const double before = total(body_.strain_energies(u));
  break_where([](std::int32_t t) { return t % 7 < 4; }, u);
  const double after = total(body_.strain_energies(u));
  const double released = total(body_.released_energies());
  std::printf("strain energy %.6g -> %.6g J, released %.6g J\n", before, after, released);
  EXPECT_NEAR(before, after + released, 1e-12 * before);
  for (const double energy : body_.released_energies()) EXPECT_GE(energy, -1e-15 * before);
}

TEST_F(FacetBody, GradualReleaseReleasesAsMuchAsOneAtOnce) {
  const auto u = random_displacement();
  const auto strain = [&](std::int32_t t) { return body_.strain(t, u); };
  const double before = total(body_.strain_energies(u));
  body_.set_release(std::make_unique<InTime>([](double since) { return 1 - since / 0x1p-18; }));
  for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); t += 3)
    body_.release(t, strain(t), 0, 0x1p-20, true);
  EXPECT_NEAR(total(body_.strain_energies(u)), before, 1e-12 * before) << "nothing is released at first";
  body_.release_bridges(self_, 0, 1e-6, strain);
  const double intact = total(body_.strain_energies(u));
  double half = 0;
  for (const double share : {0.75, 0.5, 0.25, 0.0}) {
    body_.continue_releases(0x1p-20 + (1 - share) * 0x1p-18, strain);
    const double left = total(body_.strain_energies(u));
    EXPECT_NEAR(left + total(body_.released_energies()), before, 1e-12 * before);
    if (share == 0.5) half = left;
  }
  EXPECT_FALSE(body_.is_releasing());
  const double after = total(body_.strain_energies(u));
  std::printf("strain energy %.6g J, with half of the stiffness %.6g J, at the end %.6g J\n", intact, half,
              after);
  EXPECT_NEAR(half, (intact + after) / 2, 1e-12 * before) << "linear in the share";

  fracture::BreakableBody at_once(subdomain_, test::epoxy(),
                                  fracture::make_release({.release = input::Release::facet}));
  for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); t += 3) at_once.release(t, strain(t), 0, 0);
  at_once.release_bridges(self_, 0, 0, strain);
  EXPECT_NEAR(after, total(at_once.strain_energies(u)), 1e-12 * before);
  EXPECT_LT(after, 0.99 * before);
}

TEST_F(FacetBody, GradualReleaseUnderWayIsRestored) {
  const auto u = random_displacement();
  const auto strain = [&](std::int32_t t) { return body_.strain(t, u); };
  const auto share = [](double since) { return since == 0 ? 1.0 : since < 1.5e-6 ? 0.4 : 0.0; };
  body_.set_release(std::make_unique<InTime>(share));
  for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); t += 3)
    body_.release(t, strain(t), 0, t % 2 == 0 ? 1e-6 : 2e-6, true);
  body_.release_bridges(self_, 0, 2e-6, strain);
  body_.continue_releases(3e-6, strain);
  fracture::BreakableBody again(subdomain_, test::epoxy(), std::make_unique<InTime>(share));
  again.restore({{body_.breaks().begin(), body_.breaks().end()},
                 {body_.bridge_releases().begin(), body_.bridge_releases().end()},
                 {}},
                3e-6);
  EXPECT_TRUE(again.is_releasing());
  EXPECT_EQ(again.strain_energies(u), body_.strain_energies(u));
  again.continue_releases(5e-6, strain);
  body_.continue_releases(5e-6, strain);
  EXPECT_EQ(again.strain_energies(u), body_.strain_energies(u));
  EXPECT_EQ(again.released_energies(), body_.released_energies());
}

TEST(GradualRelease, ContactGrowsAsTheStiffnessFalls) {
  geometry::Subdomain subdomain;
  subdomain.nodes.assign(some_corners.begin(), some_corners.end());
  subdomain.tetrahedra = {{0, 1, 2, 3}};
  const PdsOperators operators = make_operators(subdomain, 1);
  const ElasticityField elasticity{IsotropicElasticity(test::epoxy())};
  RandomStream stream(3, 0, "strain");
  for (int i = 0; i < 50; ++i) {
    const Symmetric strain = random_strain(stream);
    ResidualStiffness stiffness(operators, elasticity);
    double last = stiffness.energy(0, strain);
    stiffness.begin_release(0, all_edges);
    stiffness.add_contact(0, {0, 0, 1});
    for (const double share : {0.9, 0.5, 0.1, 0.0}) {
      stiffness.reduce(0, share);
      EXPECT_LE(stiffness.energy(0, strain), last * (1 + 1e-12)) << "no energy is gained";
      last = stiffness.energy(0, strain);
    }
    EXPECT_EQ(last > 0, strain[2] < 0) << "in the end only closing is resisted";
  }
}

TEST(Contact, HasItsTangent) {
  geometry::Subdomain subdomain;
  subdomain.nodes.assign(some_corners.begin(), some_corners.end());
  subdomain.tetrahedra = {{0, 1, 2, 3}};
  const PdsOperators operators = make_operators(subdomain, 1);
  const ElasticityField elasticity{IsotropicElasticity(test::epoxy())};
  for (const EdgeSet released : {all_edges, EdgeSet{7}}) {
    ResidualStiffness stiffness(operators, elasticity), tangent(operators, elasticity);
    stiffness.release(0, released);
    stiffness.set_friction(0.5);
    stiffness.add_contact(0, {0, 0.6, 0.8});
    const Symmetric closed{1e-4, -3e-4, -5e-4, 2e-5, -4e-5, 7e-5};
    Symmetric open = closed;
    for (double& component : open) component = -component;
    for (const Symmetric& strain : {closed, open}) {
      tangent.linearize(0, stiffness, stiffness.cut_tangent(0, strain));
      const Symmetric found = tangent.own_stress(0, strain), exact = stiffness.stress(0, strain);
      for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(found[i], exact[i], 1e-9 * 3300e6 * 5e-4) << i;
    }
    // A cut that slips resists across its way by its force's turning.
    Symmetric slipping = closed;
    slipping[5] = 1e-2;
    const CutTangent slips = stiffness.cut_tangent(0, slipping);
    EXPECT_TRUE(slips.is_closed);
    EXPECT_LT(slips.on_its_way, 1e-3);
    EXPECT_GT(slips.along, slips.on_its_way);
    EXPECT_LT(slips.along, 1);
    EXPECT_NEAR(norm(slips.way), 1, 1e-12);
  }
}

TEST_F(FacetBody, CrackRightThroughCarriesNothing) {
  const auto is_upper = [](const auto& p) { return p[2] > 0.0043; };
  const auto u = random_displacement();  // neighbours choose different cuts
  break_where(
      [&](std::int32_t t) {
        const auto& nodes = subdomain_.tetrahedra[index(t)];
        const auto n = std::ranges::count_if(
            nodes, [&](std::int32_t n) { return is_upper(subdomain_.nodes[index(n)]); });
        return n > 0 && n < 4;
      },
      u);
  const auto opened = displacement([&](const auto& p) { return Vector{0, 0, is_upper(p) ? 1e-5 : 0.0}; });
  std::vector<double> f(u.size());
  body_.force().evaluate(opened, f);
  const auto labels = fracture::piece_labels(self_, body_);
  std::size_t n_partial = 0;
  for (const auto t : body_.broken_tetrahedra()) n_partial += body_.residual_stiffness().carries(t) ? 1 : 0;
  std::printf("crack of %zu tetrahedra opened by 0.01 mm: largest force %.1e N; %zu carry along it\n",
              body_.broken_tetrahedra().size(), largest(f), n_partial);
  EXPECT_LT(largest(f), 1e-12);
  for (std::size_t n = 0; n < labels.size(); ++n)
    for (std::size_t m = 0; m < n; ++m)
      ASSERT_FALSE(labels[n] == labels[m] && is_upper(subdomain_.nodes[n]) != is_upper(subdomain_.nodes[m]));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::mechanics
