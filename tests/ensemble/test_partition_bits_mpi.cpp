// SPDX-License-Identifier: GPL-3.0-or-later
// Every sum, product, bound and solve shared by ranks is bitwise equal to that on one rank for any partition,
// with inexact sums and bodies in which some tetrahedra are partly broken.
#include "common/index.h"
#include "dynamics/moving_body.h"
#include "dynamics/stable_step.h"
#include "mechanics/static_solver.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"
#include "parallel/reproducible.h"

#include "dynamics/state_range.h"
#include "mechanics/coarse_space.h"
#include "mechanics/fixed_point_force.h"
#include "mechanics/stiffness_product.h"
#include "support/box_mesh.h"
#include "support/group.h"
#include "support/partitions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace crackle {
namespace CRACKLE_TEST_FILE {

using geometry::Point;
using input::BoundaryKind;
using parallel::Communicator;
using parallel::NodeField;
using plane::Face;

const Point size{0.002, 0.004, 0.012};

input::Parameters held_and_loaded(double poisson_ratio) {
  input::Parameters parameters;
  parameters.specimen.size = size;
  parameters.materials[0] = test::epoxy();
  parameters.materials[0].poisson_ratio = poisson_ratio;
  parameters.fracture.toughness = 70;
  parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}));
  parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::force, {}, {1, -7, 30}));
  parameters.boundaries.push_back(
      test::boundary(Face::y_max, BoundaryKind::velocity, {true, false, false}, {0.3, 0, 0}));
  return parameters;
}

/// A body as held by one group.
struct Share {
  Share(MPI_Comm communicator, const geometry::Realization& mesh, const test::MakePartition& partition,
        double poisson_ratio = 0.38)
      : group(communicator),
        subdomain(geometry::split(mesh, partition(mesh, group.size()))[index(group.rank())]),
        parameters(held_and_loaded(poisson_ratio)),
        body(subdomain, parameters.material(), fracture::make_release({.release = input::Release::facet})),
        loads(mechanics::make_boundary_loads(group, parameters, subdomain)) {}

  RandomStream stream(const char* name, std::int64_t number) const {
    return RandomStream(3, 0, name).substream(static_cast<std::uint64_t>(number));
  }

  /// Breaks some tetrahedra, the same ones in every partition. Collective.
  /// @return local numbers
  std::vector<std::int32_t> break_some(std::int64_t first) {
    const auto strain = [&](std::int32_t t) {
      auto random = stream("strain", subdomain.tetrahedron_number[index(t)]);
      mechanics::Symmetric eps{};
      for (double& component : eps) component = 0.01 * random.uniform(-1, 1);
      return eps;
    };
    const auto n_before = body.changes().size();
    for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t)
      if (subdomain.tetrahedron_number[index(t)] % 9 == first) body.release(t, strain(t), 0, 0);
    body.release_bridges(group, 0, 0, strain);
    const auto changes = body.changes().subspan(n_before);
    return {changes.begin(), changes.end()};
  }

  /// A field's values, from the realization's node number and the position; with current ghosts. Collective.
  template <class Value>
  NodeField field(const Value& value) const {
    NodeField result(group, subdomain.layout);
    for (std::size_t n = 0; n < static_cast<std::size_t>(subdomain.layout.n_owned); ++n) {
      const std::array<double, 3> at_node = value(subdomain.layout.number[n], subdomain.nodes[n]);
      std::ranges::copy(at_node, result.local().begin() + static_cast<std::ptrdiff_t>(3 * n));
    }
    result.update_ghosts();
    return result;
  }

  std::vector<std::uint8_t> held() const {
    std::vector<std::uint8_t> marks(3 * subdomain.nodes.size(), 0);
    for (std::size_t n = 0; n < subdomain.nodes.size(); ++n)
      for (std::size_t i = 0; i < 3; ++i) marks[3 * n + i] = subdomain.nodes[n][2] == 0 ? 1 : 0;
    return marks;
  }

  Communicator group;
  geometry::Subdomain subdomain;
  input::Parameters parameters;
  fracture::BreakableBody body;
  mechanics::Conditions loads;
};

/// Operands of very different size and kind, so that the scale of one does not suit the next.
std::array<double, 3> operand(int number, std::int64_t node, const Point& p) {
  auto stream = RandomStream(11, 0, "operand")
                    .substream(static_cast<std::uint64_t>(number))
                    .substream(static_cast<std::uint64_t>(node));
  const double scale = std::pow(10.0, (number * 7) % 23 - 15) * (1 + 0.1 * number);
  const auto noise = [&] { return stream.uniform(-1, 1); };
  switch (number % 6) {
    case 0:  // rough
      return {scale * noise(), scale * noise(), scale * noise()};
    case 1:  // smooth
      return {scale * (p[0] + 3 * p[1]) / size[1], -scale * p[1] / size[1], scale * p[2] / size[2]};
    case 2:  // at one node only
      return {node == 40 ? scale : 0, 0, node == 41 ? -0.3 * scale : 0};
    case 3:  // nearly a translation: hardly any force
      return {scale, -0.7 * scale, scale * (1 + 1e-7 * noise())};
    case 4: {  // extremely rough, after one with almost no force
      const auto sign = [&] { return noise() < 0 ? -0.985 : 0.985; };
      return {scale * sign(), scale * sign(), scale * sign()};
    }
    default:
      return {scale * std::sin(700 * p[2]), scale * std::cos(500 * p[1]), 1e-3 * scale * noise()};
  }
}

class PartitionBits : public ::testing::Test {
protected:
  PartitionBits() : mesh_(test::make_box({.size = size, .cells = {3, 5, 14}, .disturbance = 0.2})) {}

  /// Calls compare(body as shared by all ranks, body as held by this rank alone).
  template <class Compare>
  void on_partitions(const Compare& compare) {
    for (const auto& [name, make] : test::hostile_partitions(size)) {
      SCOPED_TRACE(name);
      Share shared(test::group(), mesh_, make);
      Share alone(MPI_COMM_SELF, mesh_, make);
      compare(shared, alone);
    }
  }

  /// Number of components of owned nodes that differ.
  static std::int64_t n_different(const Share& shared, std::span<const double> mine, const Share& alone,
                                  std::span<const double> all) {
    std::int64_t n = 0;
    for (std::size_t i = 0; i < 3 * static_cast<std::size_t>(shared.subdomain.layout.n_owned); ++i) {
      const auto place =
          std::ranges::lower_bound(alone.subdomain.layout.number, shared.subdomain.layout.number[i / 3]) -
          alone.subdomain.layout.number.begin();
      n += mine[i] != all[3 * index(place) + i % 3] ? 1 : 0;
    }
    return n;
  }

  static void expect_equal_ranges(Share& shared, Share& alone, int number) {
    const auto range = [&](Share& share) {
      auto law = test::unbreakable(share.subdomain, 35e6);
      const auto at = [&](std::int64_t node, const Point& p) { return operand(number, node, p); };
      const dynamics::MotionState state{share.field(at), share.field(at)};
      const dynamics::MotionContext context{&share.group, &share.body, &share.loads, &law};
      return dynamics::expected_range(context, dynamics::Terms(context, state, 64), 0.1, 2e-5, state);
    };
    const auto mine = range(shared), all = range(alone);
    EXPECT_EQ(mine.stretch, all.stretch);
    EXPECT_EQ(mine.velocity, all.velocity);
    EXPECT_EQ(mine.force, all.force);
  }

  template <class Real>
  static void compare_products(Share& shared, Share& alone, double accuracy);

  geometry::Realization mesh_;
};

template <class Real>
std::unique_ptr<mechanics::StiffnessProduct<Real>> product_of(const Share& share) {
  return std::make_unique<mechanics::StiffnessProduct<Real>>(
      share.group, share.subdomain, share.body.operators(), share.body.elasticity(), share.body.edges(),
      share.body.residual_stiffness());
}

template <class Real>
std::vector<Real> converted(std::span<const double> values) {
  return {values.begin(), values.end()};
}

/// Products of many operands, of the body as it breaks.
/// @param accuracy of a force, relative to modulus times length times the largest displacement
template <class Real>
void PartitionBits::compare_products(Share& shared, Share& alone, double accuracy) {
  shared.break_some(4);
  alone.break_some(4);
  const auto shared_product = product_of<Real>(shared);
  const auto product = product_of<Real>(alone);
  for (int number = 0; number < 36; ++number) {
    if (number == 18) {
      shared_product->update(shared.break_some(7));
      product->update(alone.break_some(7));
    }
    const auto at = [&](std::int64_t node, const Point& p) { return operand(number, node, p); };
    const NodeField field = shared.field(at), whole_field = alone.field(at);
    const auto mine = converted<Real>(field.local()), all = converted<Real>(whole_field.local());
    std::vector<Real> force(field.owned().size(), -1), whole_force(whole_field.owned().size(), -1);
    EXPECT_EQ(shared_product->apply(mine, force), product->apply(all, whole_force)) << "operand " << number;
    const std::vector<double> exact(force.begin(), force.end()),
        whole_exact(whole_force.begin(), whole_force.end());
    EXPECT_EQ(n_different(shared, exact, alone, whole_exact), 0) << "operand " << number;
    // It must also be the correct product: a force spoilt by overflow could well be equal everywhere.
    std::vector<double> plain(all.size());
    alone.body.force().evaluate(std::vector<double>(all.begin(), all.end()), plain);
    double largest = 0, error = 0;
    for (std::size_t i = 0; i < plain.size(); ++i) {
      largest = std::max(largest, std::abs(static_cast<double>(all[i])));
      error = std::max(error, std::abs(plain[i] - whole_exact[i]));
    }
    const double stiffness = shared.parameters.materials[0].youngs_modulus * 1e-3;
    EXPECT_LT(error, accuracy * stiffness * largest) << "operand " << number;
  }
}

TEST_F(PartitionBits, StiffnessProducts) {
  on_partitions([&](Share& shared, Share& alone) { compare_products<double>(shared, alone, 1e-12); });
}

TEST_F(PartitionBits, StiffnessProductsInSinglePrecision) {
  on_partitions([&](Share& shared, Share& alone) { compare_products<float>(shared, alone, 1e-5); });
}

TEST_F(PartitionBits, AnOperandThatIsNotFiniteIsRefusedByAll) {
  const auto partition = test::hostile_partitions(size).front().make;
  const Share shared(test::group(), mesh_, partition);
  const auto product = product_of<double>(shared);
  std::vector<double> force(3 * static_cast<std::size_t>(shared.subdomain.layout.n_owned));
  for (const double wrong : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    const NodeField operand = shared.field([&](std::int64_t node, const Point&) {
      return std::array<double, 3>{0, node == 100 ? wrong : 1, 0};
    });
    EXPECT_THROW(product->apply(operand.local(), force), std::runtime_error);
  }
}

TEST_F(PartitionBits, StaticSolves) {
  on_partitions([&](Share& shared, Share& alone) {
    std::optional<mechanics::StaticSolver> shared_solver, solver;
    const auto make = [](const Share& share, auto& made) {
      made.emplace(share.group, share.subdomain, share.body.operators(), share.body.elasticity(),
                   share.body.edges(), share.body.residual_stiffness(), share.held());
    };
    make(shared, shared_solver);
    make(alone, solver);
    NodeField mine(shared.group, shared.subdomain.layout), all(alone.group, alone.subdomain.layout);
    for (int number = 0; number < 3; ++number) {
      if (number > 0) {
        shared_solver->release(shared.break_some(number));
        solver->release(alone.break_some(number));
      }
      const auto force_of = [&](const Share& share) {
        std::vector<double> force(3 * static_cast<std::size_t>(share.subdomain.layout.n_owned));
        share.loads.add_forces(0, force);
        return force;
      };
      const int n_shared = shared_solver->solve(force_of(shared), mine);
      EXPECT_EQ(n_shared, solver->solve(force_of(alone), all));
      EXPECT_EQ(n_different(shared, mine.owned(), alone, all.owned()), 0) << "solve " << number;
    }
  });
}

TEST_F(PartitionBits, CoarseCorrections) {
  on_partitions([&](Share& shared, Share& alone) {
    shared.break_some(4);
    alone.break_some(4);
    const auto held = shared.held(), all_held = alone.held();
    mechanics::CoarseSpace mine(shared.group, shared.subdomain, shared.body.edges(), held);
    mechanics::CoarseSpace all(alone.group, alone.subdomain, alone.body.edges(), all_held);
    mine.factorize(shared.body.operators(), shared.body.elasticity(), shared.body.residual_stiffness());
    all.factorize(alone.body.operators(), alone.body.elasticity(), alone.body.residual_stiffness());
    for (int number = 0; number < 12; ++number) {
      const auto at = [&](std::int64_t node, const Point& p) { return operand(number, node, p); };
      const auto corrected = [&](mechanics::CoarseSpace& space, const Share& share) {
        const auto residual = converted<float>(share.field(at).owned());
        const std::vector<std::array<float, 6>> block(residual.size() / 3, {1, 2, 3, 0.5, 0.25, 0.125});
        std::vector<float> result(residual.size());
        space.precondition(residual, block, result);
        return std::vector<double>(result.begin(), result.end());
      };
      const auto correction = corrected(mine, shared), whole = corrected(all, alone);
      EXPECT_EQ(n_different(shared, correction, alone, whole), 0) << "residual " << number;
    }
  });
}

TEST_F(PartitionBits, Sums) {
  on_partitions([&](Share& shared, Share& alone) {
    for (int number = 0; number < 12; ++number) {
      // Terms of all sizes that nearly cancel.
      const auto first = [&](std::int64_t node, const Point& p) {
        auto values = operand(number, node, p);
        for (double& value : values) value *= std::pow(10.0, static_cast<double>(node % 19) - 9);
        return values;
      };
      const auto second = [&](std::int64_t node, const Point& p) { return operand(number + 5, node, p); };
      const NodeField a = shared.field(first), b = shared.field(second);
      const NodeField all_a = alone.field(first), all_b = alone.field(second);
      EXPECT_EQ(parallel::reproducible_dot(shared.group.get(), a.owned(), b.owned()),
                parallel::reproducible_dot(alone.group.get(), all_a.owned(), all_b.owned()));
      EXPECT_EQ(parallel::exact_dot(shared.group, a.owned(), b.owned()),
                parallel::exact_dot(alone.group, all_a.owned(), all_b.owned()));
      EXPECT_EQ(parallel::exact_sum(shared.group, a.owned()),
                parallel::exact_sum(alone.group, all_a.owned()));
    }
  });
}

/// Numbers from which scales are chosen.
TEST_F(PartitionBits, Bounds) {
  on_partitions([&](Share& shared, Share& alone) {
    shared.break_some(4);
    alone.break_some(4);
    EXPECT_EQ(dynamics::largest_frequency(shared.group, shared.subdomain, shared.body.operators(),
                                          shared.body.force()),
              dynamics::largest_frequency(alone.group, alone.subdomain, alone.body.operators(),
                                          alone.body.force()));
    for (int number = 0; number < 12; ++number) {
      expect_equal_ranges(shared, alone, number);
      const auto stretch = [&](const Share& share) {
        const std::vector<double> no_mass(static_cast<std::size_t>(share.subdomain.layout.n_owned), 1.0);
        mechanics::FixedPointForce<double> force(
            share.subdomain, share.body.operators(), share.body.elasticity(), share.body.edges(),
            share.body.residual_stiffness(), no_mass, {1, 1, 1e9}, best_instruction_set());
        for (std::size_t n = 0; n < share.subdomain.nodes.size(); ++n)
          for (std::size_t i = 0; i < 3; ++i)
            force.nodes()[n].displacement[i] =
                std::llrint(1e6 * operand(6 * number, share.subdomain.layout.number[n], {})[i] /
                            std::pow(10.0, (number * 42) % 23 - 15));
        return parallel::largest_of_all(share.group, force.largest_stretch());
      };
      EXPECT_EQ(stretch(shared), stretch(alone));
    }
  });
}

/// Tetrahedra differ in strength and stiffness, so that each rank has other references.
TEST_F(PartitionBits, StrainEnergies) {
  on_partitions([&](Share& shared, Share& alone) {
    const auto energies = [&](Share& share) {
      std::vector<mechanics::IsotropicElasticity> elasticity;
      std::vector<double> strengths;
      for (const auto number : share.subdomain.tetrahedron_number) {
        const auto n = static_cast<double>(number);
        elasticity.emplace_back(input::Material{2e9 + 1e7 * std::fmod(n, 100), 0.38, 1180});
        strengths.push_back(35e6 * (1 + std::fmod(n, 7)));
      }
      fracture::BreakableBody body(
          share.subdomain, {mechanics::ElasticityField(std::move(elasticity)), share.body.material().density},
          fracture::make_release({.release = input::Release::facet}));
      fracture::FractureLaw law(std::make_unique<fracture::TulerButcher>(share.parameters.fracture, 1e4,
                                                                         std::move(strengths), 5e-9));
      const auto strain = [](std::int32_t) { return mechanics::Symmetric{0.02, 0, 0.01, 0, 0, 0}; };
      for (std::int32_t t = 0; t < share.subdomain.n_tetrahedra(); ++t)
        if (share.subdomain.tetrahedron_number[index(t)] % 9 == 1) body.release(t, strain(t), 0, 0);
      body.release_bridges(share.group, 0, 0, strain);
      const auto at = [](std::int64_t node, const Point& p) {
        return std::array<double, 3>{1e-5 * std::sin(700 * p[2]), 1e-5 * std::cos(500 * p[1]),
                                     1e-6 * static_cast<double>(node % 7)};
      };
      dynamics::MotionState state{share.field(at), share.field(at)};
      std::vector<double> result;
      for (const auto precision : {input::Precision::mixed, input::Precision::double_}) {
        const auto motion = dynamics::make_fixed_point_motion(
            {&share.group, &body, &share.loads, &law, 0, true}, precision, 0, 1e-5, state);
        motion->read(state);
        result.push_back(motion->strain_energy(state));
      }
      return result;
    };
    EXPECT_EQ(energies(shared), energies(alone));
  });
}

/// The largest is that of one edge, whose rounding differs between materials.
TEST_F(PartitionBits, RangesOfManyMaterials) {
  for (const auto& [name, make] : test::hostile_partitions(size)) {
    SCOPED_TRACE(name);
    for (int i = 0; i < 12; ++i) {
      const double poisson_ratio = 0.05 + 0.033 * i;
      Share shared(test::group(), mesh_, make, poisson_ratio);
      Share alone(MPI_COMM_SELF, mesh_, make, poisson_ratio);
      expect_equal_ranges(shared, alone, i);
    }
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle
