// SPDX-License-Identifier: GPL-3.0-or-later
// Parts of the static solver: block factors, interrupted conjugate gradients, cells of nodes.
#include "common/index.h"
#include "fracture/breakable_body.h"

#include "kernels/cell_kernels.h"
#include "mechanics/block_factors.h"
#include "mechanics/conjugate_gradients.h"
#include "mechanics/node_cells.h"
#include "support/box_mesh.h"

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <random>
#include <vector>

namespace crackle::mechanics {
namespace CRACKLE_TEST_FILE {

class Numbers {
public:
  double operator()() { return static_cast<double>(engine_()) / 0x1p31 - 1; }

private:
  std::mt19937 engine_{7};
};

TEST(BlockFactors, SolveAsEigenDoes) {
  constexpr std::int32_t n_rows = 40;
  Numbers number;
  std::vector<PlacedBlock> blocks;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(6 * n_rows, 6 * n_rows);
  for (std::int32_t row = 0; row < n_rows; ++row) {
    for (std::int32_t column = 0; column <= row; ++column) {
      // A band and a few entries far from it.
      if (row - column > 2 && (row + 3 * column) % 17 != 0) continue;
      Block block;
      for (double& entry : block.reshaped()) entry = number();
      if (row == column) block = (block + block.transpose() + 60 * Block::Identity()).eval();
      blocks.push_back({row, column, block});
      matrix.block<6, 6>(6 * row, 6 * column) = block;
      matrix.block<6, 6>(6 * column, 6 * row) = block.transpose();
    }
  }
  BlockFactors factors(n_rows);
  factors.factorize(blocks);
  Eigen::VectorXd right(6 * n_rows);
  for (double& entry : right) entry = number();
  std::vector<double> solution(right.begin(), right.end());
  factors.solve(solution);
  const Eigen::VectorXd expected = matrix.ldlt().solve(right);
  double error = 0;
  for (std::size_t i = 0; i < solution.size(); ++i)
    error = std::max(error, std::abs(solution[i] - expected[static_cast<Eigen::Index>(i)]));
  std::printf("largest difference from Eigen's dense solution: %.1e\n", error);
  EXPECT_LT(error, 1e-14);
}

/// -1, 2, -1 without a preconditioner: takes as many iterations as there are unknowns.
struct Chain {
  std::vector<float> values = std::vector<float>(60);

  static double dot(std::span<const float> a, std::span<const float> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += static_cast<double>(a[i]) * static_cast<double>(b[i]);
    return sum;
  }
  std::span<float> direction() { return values; }
  double multiply(std::span<float> image) const {
    for (std::size_t i = 0; i < values.size(); ++i)
      image[i] = 2 * values[i] - (i > 0 ? values[i - 1] : 0) - (i + 1 < values.size() ? values[i + 1] : 0);
    return dot(values, image);
  }
  static double precondition(std::span<const float> residual, std::span<float> result) {
    std::ranges::copy(residual, result.begin());
    return dot(residual, result);
  }
};

int iterations(ConjugateGradients<Chain>::Start start_of_later_runs) {
  using Start = ConjugateGradients<Chain>::Start;
  const parallel::Communicator self(MPI_COMM_SELF);
  Chain chain;
  ConjugateGradients<Chain> gradients(self, chain);
  std::vector<float> residual(chain.values.size(), 0.0F), correction(residual.size());
  residual[7] = 1;
  int n = 0;
  double tolerance = 1;
  for (int run = 0; run < 5; ++run) {
    tolerance /= 10;
    n +=
        gradients.solve(residual, correction, tolerance, 1000, run == 0 ? Start::afresh : start_of_later_runs)
            .n_iterations;
  }
  return n;
}

TEST(ConjugateGradients, GoOnAfterAnInterruption) {
  using Start = ConjugateGradients<Chain>::Start;
  const int afresh = iterations(Start::afresh), beside = iterations(Start::beside_the_last);
  std::printf("60 unknowns in 5 runs: %d iterations afresh, %d beside the last direction\n", afresh, beside);
  EXPECT_LE(beside, 62);
  EXPECT_GT(afresh, beside + 20) << "or the test says nothing";
}

TEST(NodeCells, ShareEveryNodeAmongNeighbours) {
  const auto mesh = test::make_box({.size = {0.005, 0.02, 0.06}, .cells = {6, 20, 60}});
  const auto subdomain = geometry::split(mesh, geometry::partition(mesh, 1)).front();
  const auto cells = make_node_cells(parallel::Communicator(MPI_COMM_SELF), subdomain, make_edges(subdomain));
  EXPECT_GT(cells.size(), 20);
  std::size_t n_shared = 0;
  for (std::size_t n = 0; n < subdomain.nodes.size(); ++n) {
    const auto& shares = cells.shares[n];
    std::int32_t sum = 0;
    for (std::size_t s = 0; s < kernels::n_shares; ++s) {
      sum += shares.weight[s];
      if (shares.weight[s] == 0) continue;
      EXPECT_TRUE(s == 0 || shares.cell[s - 1] < shares.cell[s]);
      const auto c = index(shares.cell[s]);
      EXPECT_LT(norm(subdomain.nodes[n] - cells.centre[c]), 1.5 * cells.extent[c]);
    }
    EXPECT_EQ(sum, NodeCells::whole);
    n_shared += shares.weight[1] > 0;
  }
  // Neighbouring cells overlap.
  EXPECT_GT(n_shared, subdomain.nodes.size() / 2);
}

TEST(CellKernels, GiveTheSameBitsWithEveryInstructionSet) {
  using namespace kernels;
  Numbers number;
  constexpr std::size_t n_nodes = 50, n_cells = 9;
  std::vector<CellGroup> groups;
  std::vector<NodeInCells> nodes;
  std::vector<float> load, block;
  for (std::int32_t g = 0; g < 5; ++g) groups.push_back({{g, g + 1, g + 2, g + 4}, 10});
  for (std::size_t n = 0; n < n_nodes; ++n) {
    NodeInCells node{{32, 16, 12, 4}, {}, static_cast<std::int32_t>((7 * n) % n_nodes)};
    for (float& x : node.place) x = static_cast<float>(number());
    nodes.push_back(node);
    for (int i = 0; i < 3; ++i) load.push_back(static_cast<float>(number()));
    for (int i = 0; i < 6; ++i) block.push_back(static_cast<float>(number()));
  }
  std::vector<CornerShare> corners;
  for (int i = 0; i < 7; ++i) {
    auto& corner = corners.emplace_back();
    for (auto* three : {corner.gradient, corner.free, corner.arm})
      for (int k = 0; k < 3; ++k) three[k] = number();
    corner.cell = i % 3;
  }
  double stiffness[6][6];
  for (auto& row : stiffness)
    for (double& entry : row) entry = 1e6 * number();
  struct Results {
    std::vector<CellNumbers> sums{n_cells}, strain{18}, stress{18};
    std::vector<CellIntegers> energies{6};
    std::vector<float> result = std::vector<float>(3 * n_nodes);
    std::int32_t largest = 0;
  };
  const auto compute = [&](InstructionSet set) {
    const CellKernels& kernels = cell_kernels(set);
    Results r;
    const NodesInCells in_cells{groups.data(), groups.size(), nodes.data()};
    kernels.add_loads(in_cells, load.data(), 1e9, r.sums.data());
    r.largest = kernels.add_motions(in_cells, load.data(), block.data(), r.sums.data(), r.result.data());
    kernels.find_strains(corners.data(), corners.size(), 3, stiffness, r.strain.data(), r.stress.data());
    kernels.add_energies(r.stress.data(), r.strain.data() + 6, r.energies.data());
    return r;
  };
  const Results expected = compute(InstructionSet::generic);
  EXPECT_NE(expected.largest, 0);
  const auto same = [](const auto& a, const auto& b) {
    return std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
  };
  for (const auto set : available_instruction_sets()) {
    const Results found = compute(set);
    EXPECT_TRUE(same(found.sums, expected.sums)) << to_string(set);
    EXPECT_TRUE(same(found.result, expected.result)) << to_string(set);
    EXPECT_TRUE(same(found.strain, expected.strain)) << to_string(set);
    EXPECT_TRUE(same(found.stress, expected.stress)) << to_string(set);
    EXPECT_TRUE(same(found.energies, expected.energies)) << to_string(set);
    EXPECT_EQ(found.largest, expected.largest) << to_string(set);
  }
}

TEST(CellKernels, ConvertDisplacementsAndForcesOfNodes) {
  using namespace kernels;
  Numbers number;
  constexpr std::size_t n_nodes = 101;
  constexpr double scale = 0x1p29, quantum = 0x1p-12;
  std::vector<float> displacement;
  std::vector<std::int32_t> forces;
  for (std::size_t i = 0; i < 3 * n_nodes; ++i) {
    displacement.push_back(static_cast<float>(number()));
    forces.push_back(static_cast<std::int32_t>(0x1p31 * number()));
  }
  for (const auto set : available_instruction_sets()) {
    const CellKernels& kernels = cell_kernels(set);
    std::vector<NodeRecord<float>> nodes(n_nodes, NodeRecord<float>{{}, 0.25F, {1, 2, 3, 0}});
    kernels.set_displacements(nodes.data(), n_nodes, displacement.data(), scale);
    __int128 work = 0;
    for (std::size_t n = 0; n < n_nodes; ++n) {
      EXPECT_EQ(nodes[n].inverse_mass, 0.25F);
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(nodes[n].displacement[i],
                  std::llrint(scale * static_cast<double>(displacement[3 * n + i])));
        EXPECT_EQ(nodes[n].force[i], 0);
        nodes[n].force[i] = forces[3 * n + i];
        work += static_cast<__int128>(nodes[n].displacement[i]) * forces[3 * n + i];
      }
    }
    std::vector<float> result(3 * n_nodes);
    EXPECT_TRUE(kernels.get_forces(nodes.data(), n_nodes, quantum, result.data()) == work) << to_string(set);
    for (std::size_t i = 0; i < result.size(); ++i)
      EXPECT_EQ(result[i], static_cast<float>(quantum * forces[i])) << to_string(set);
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::mechanics
