// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/scaling.h"

#include "ensemble/estimate.h"
#include "geometry/partition.h"
#include "geometry/subdomain.h"
#include "support/box_mesh.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

/// @param n cells along each edge
geometry::Realization cube(int n) {
  return test::make_box({.size = {0.01, 0.01, 0.01}, .cells = {n, n, n}, .disturbance = 0.2});
}

TEST(PartSizes, AreThoseOfPartitions) {
  const auto mesh = cube(20);
  const PartSizes sizes(mesh, 0, 8);
  const double n = sizes.n_tetrahedra();
  EXPECT_EQ(n, static_cast<double>(mesh.tetrahedra.size()));
  const LargestPart whole = sizes.of(1);
  EXPECT_EQ(whole.tetrahedra, n);
  EXPECT_EQ(whole.ghosts, 0);
  for (const int n_parts : {2, 8}) {
    const LargestPart found = sizes.of(n_parts);
    double tetrahedra = 0, ghosts = 0;
    for (const auto& part : geometry::split(mesh, geometry::partition(mesh, n_parts))) {
      tetrahedra = std::max<double>(tetrahedra, part.n_tetrahedra());
      ghosts = std::max<double>(ghosts, static_cast<double>(part.layout.ghosts.size()));
    }
    EXPECT_NEAR(found.tetrahedra, tetrahedra, 1e-6);
    EXPECT_NEAR(found.ghosts, ghosts, 1e-6);
    EXPECT_GE(found.neighbours, 1);
    EXPECT_LT(found.neighbours, n_parts);
  }
}

/// Between partitions and beyond them sizes fall, but more of them is surface.
TEST(PartSizes, EfficiencyFallsWithTheNumberOfParts) {
  const auto mesh = cube(20);
  const PartSizes sizes(mesh, 0, 1024);
  double computed = sizes.n_tetrahedra(), share = 0;
  for (int n_parts = 2; n_parts <= 1024; n_parts *= 2) {
    const LargestPart part = sizes.of(n_parts);
    std::printf("%4d parts: %.0f tetrahedra, %.0f ghosts of %.0f parts\n", n_parts, part.tetrahedra,
                part.ghosts, part.neighbours);
    EXPECT_LT(part.tetrahedra, sizes.of(n_parts / 2).tetrahedra);
    EXPECT_GT(n_parts * part.tetrahedra, computed) << n_parts;
    EXPECT_GT(part.ghosts / part.tetrahedra, share);
    computed = n_parts * part.tetrahedra;
    share = part.ghosts / part.tetrahedra;
  }
}

/// A coarse mesh predicts the parts of a finer one.
TEST(PartSizes, OfAFinerMesh) {
  const auto fine = cube(32);
  const auto coarse = cube(16);
  const PartSizes sizes(coarse, 0, 8, 8);
  EXPECT_EQ(sizes.n_tetrahedra(), static_cast<double>(fine.tetrahedra.size()));
  for (const int n_parts : {2, 8}) {
    const LargestPart expected = sizes.of(n_parts), found = largest_part(fine, n_parts);
    std::printf("%d parts: %.0f tetrahedra expected, %.0f found; %.0f ghosts expected, %.0f found\n", n_parts,
                expected.tetrahedra, found.tetrahedra, expected.ghosts, found.ghosts);
    EXPECT_NEAR(expected.tetrahedra, found.tetrahedra, 0.05 * found.tetrahedra);
    EXPECT_NEAR(expected.ghosts, found.ghosts, 0.25 * found.ghosts);
  }
}

TEST(PartSizes, CompactPartsConsistOfMoreSurfaceTheSmallerTheyAre) {
  EXPECT_EQ(compact_part(1e6, 1), 1e6);
  const double large = compact_part(1e8, 100) / 1e6, small = compact_part(1e6, 100) / 1e4;
  EXPECT_GT(large, 1);
  EXPECT_GT(small, 1.2);
  EXPECT_NEAR((small - 1) / (large - 1), std::cbrt(100), 1e-9);
  EXPECT_EQ(compact_part(5, 2), 5) << "not more than there are";
}

TEST(GroupTraffic, IsLatencyAndBytes) {
  constexpr Network network{.latency = 1e-6, .bandwidth = 1e9};
  constexpr GroupTraffic traffic{.exchanges = 100, .bytes_per_ghost = 12, .agreements = 10};
  constexpr LargestPart part{.tetrahedra = 0, .ghosts = 1000, .neighbours = 5};
  EXPECT_EQ(traffic.seconds(1, part, network), 0);
  EXPECT_NEAR(traffic.seconds(64, part, network), 100 * (5e-6 + 12e-6) + 10 * 6e-6, 1e-12);
}

TEST(RefinedCost, GrowsAsTheMesh) {
  MeasuredCost cost;
  cost.setup = cost.step = cost.first_solve = cost.n_nodes = 1;
  const MeasuredCost finer = refined(cost, 8);
  EXPECT_EQ(finer.setup, 8);
  EXPECT_EQ(finer.step, 8);
  EXPECT_EQ(finer.n_nodes, 8);
  EXPECT_NEAR(finer.first_solve, 16, 1e-12);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
