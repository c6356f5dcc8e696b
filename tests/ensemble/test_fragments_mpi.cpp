// SPDX-License-Identifier: GPL-3.0-or-later
// Fragments: their numbers and sums, and those that leave the range of the numbers.
#include "dynamics/fragments.h"

#include "common/index.h"
#include "dynamics/sample_run.h"
#include "dynamics/term.h"
#include "fracture/connectivity.h"
#include "parallel/communicator.h"

#include "support/box_mesh.h"
#include "support/group.h"
#include "support/partitions.h"
#include "support/same_result.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdio>
#include <utility>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

/// Blocks of one and of three cells of 1 m^3, and a third of one cell, all of whose tetrahedra are broken.
/// The first is frozen.
class Blocks : public testing::Test {
protected:
  Blocks()
      : mesh_(test::make_box({.size = {1, 1, 7}, .cells = {1, 1, 7}, .removed = [](const geometry::Point& p) {
                                return (p[2] > 1 && p[2] < 2) || (p[2] > 5 && p[2] < 6);
                              }})) {}

  SampleResult result_on(const parallel::Communicator& group, const geometry::Partition& partition) const {
    const auto parts = geometry::split(mesh_, partition);
    const geometry::Subdomain& part = parts[index(group.rank())];
    fracture::BreakableBody body(part, test::epoxy());
    for (std::int32_t t = 0; t < part.n_tetrahedra(); ++t)
      if (part.nodes[index(part.tetrahedra[index(t)][0])][2] > 5.5) body.release(t, {}, 0, 0);
    MotionState state{parallel::NodeField(group, part.layout), parallel::NodeField(group, part.layout)};
    std::vector<std::uint8_t> frozen;
    for (std::size_t n = 0; n < index(part.layout.n_owned); ++n) {
      const geometry::Point& p = part.nodes[n];
      frozen.push_back(p[2] < 1.5 ? 1 : 0);
      state.displacement.owned()[3 * n] = p[2] < 1.5 ? 10 : 0;
      // The second turns about its axis x = y = 1/2 while it moves along it; the third flies.
      const Vector v = p[2] < 1.5   ? Vector{}
                       : p[2] < 5.5 ? Vector{0.5 - p[1], p[0] - 0.5, 2}
                                    : Vector{0, 3, 0};
      for (std::size_t i = 0; i < 3; ++i) state.velocity.owned()[3 * n + i] = v[i];
    }
    const auto labels = fracture::piece_labels(group, body);
    SampleResult result;
    result.fragments =
        find_fragments(group, body, labels, frozen, state.displacement.owned(), state.velocity.owned());
    result.fragment_history = {count_fragments(group, body, labels, frozen, 0.25)};
    return result;
  }

  const geometry::Realization mesh_;
};

TEST_F(Blocks, AreNumberedByMassAndSummedExactly) {
  const parallel::Communicator world(test::group()), self(MPI_COMM_SELF);
  const double density = test::epoxy().density;
  for (const auto& [name, make] : test::hostile_partitions({1, 1, 7})) {
    SCOPED_TRACE(name);
    const SampleResult found = result_on(world, make(mesh_, world.size()));
    if (!world.is_root()) {
      EXPECT_TRUE(found.fragments.pieces.empty());
      continue;
    }
    const auto& [pieces, dust, mass, of_node] = found.fragments;
    ASSERT_EQ(pieces.size(), 2U);
    EXPECT_NEAR(mass, 5 * density, 1e-9 * density);
    const Fragment &large = pieces[0], &small = pieces[1];
    EXPECT_EQ(large.first_node, 8);
    EXPECT_EQ(large.n_nodes, 16);
    EXPECT_NEAR(large.mass, 3 * density, 1e-9 * density);
    EXPECT_NEAR(large.volume, 3, 1e-9);
    EXPECT_NEAR(large.velocity[2], 2, 1e-9);
    EXPECT_NEAR(norm(large.extent - Vector{1, 1, 3}), 0, 1e-12);
    // All nodes have the distance sqrt(1/2) from an axis; the mean turns with them if they differ in mass.
    EXPECT_NEAR(large.kinetic, 0.5 * 3 * density * (4 + 0.5), 1e-9 * density);
    EXPECT_LT(large.kinetic_of_mean(), large.kinetic);
    EXPECT_FALSE(large.is_frozen);
    EXPECT_EQ(small.first_node, 0);
    EXPECT_EQ(small.n_nodes, 8);
    EXPECT_NEAR(small.center[0], 10.5, 1e-9);
    EXPECT_NEAR(small.center[2], 0.5, 1e-9);
    EXPECT_EQ(small.kinetic, 0);
    EXPECT_TRUE(small.is_frozen);
    EXPECT_EQ(dust.n_nodes, 8);
    EXPECT_NEAR(dust.mass, density, 1e-9 * density);
    EXPECT_NEAR(dust.kinetic, 0.5 * density * 9, 1e-9 * density);
    ASSERT_EQ(of_node.size(), 32U);
    for (std::size_t n = 0; n < of_node.size(); ++n) EXPECT_EQ(of_node[n], n < 8 ? 1 : n < 24 ? 0 : -1);
    const FragmentCount& count = found.fragment_history.front();
    EXPECT_EQ(count.time, 0.25);
    EXPECT_EQ(count.number, 2);
    EXPECT_EQ(count.largest_mass, large.mass);
    EXPECT_EQ(count.second_mass, small.mass);
    EXPECT_EQ(count.dust, 8);
    EXPECT_EQ(count.dust_mass, dust.mass);
    EXPECT_EQ(count.frozen, 1);
    EXPECT_EQ(count.frozen_mass, small.mass);
    const auto& alone = test::reference([&] { return result_on(self, make(mesh_, 1)); });
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_EQ(pieces[k].mass, alone.fragments.pieces[k].mass);
      EXPECT_EQ(pieces[k].center, alone.fragments.pieces[k].center);
      EXPECT_EQ(pieces[k].velocity, alone.fragments.pieces[k].velocity);
      EXPECT_EQ(pieces[k].kinetic, alone.fragments.pieces[k].kinetic);
    }
  }
}

/// A bar on a neck at its side, off which a dead load tears it; then it spins and is carried away.
input::Parameters torn_off_bar() {
  auto parameters = test::brittle({0.002, 0.004, 0.012});
  parameters.time.start = input::Start::rest;
  parameters.time.integrator = input::Integrator::verlet;
  parameters.time.precision = input::Precision::double_;
  parameters.time.duration = 2e-3;
  parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}));
  parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::force, {}, {0, 0, 100}));
  parameters.output.frames = 3;
  return parameters;
}

TEST(FragmentsThatLeave, StandStillWithTheSameBitsOnAnyRanksAndAfterAnyInterruption) {
  const parallel::Communicator world(test::group()), self(MPI_COMM_SELF);
  const auto parameters = torn_off_bar();
  const auto mesh = test::make_box(
      {.size = parameters.specimen.size,
       .cells = {2, 4, 12},
       .disturbance = 0.2,
       .removed = [](const geometry::Point& p) { return p[2] > 0.002 && p[2] < 0.003 && p[1] < 0.003; }});
  const auto part = [&](const parallel::Communicator& group) {
    return geometry::split(mesh, geometry::partition(mesh, group.size()),
                           parameters.fracture.length)[index(group.rank())];
  };
  // In pieces, before and after something has been frozen.
  std::vector<std::byte> saved;
  SampleResult pieces;
  int n_pieces = 0;
  do {
    int n_polls = 0;
    SampleControl control;
    control.stop = [&] { return ++n_polls > 40; };
    control.save = [&](std::span<const std::byte> bytes) { saved.assign(bytes.begin(), bytes.end()); };
    if (world.is_root()) control.checkpoint = saved;
    pieces = run_sample(world, parameters, parameters.output, part(world), control);
    ++n_pieces;
  } while (pieces.suspended);
  if (!world.is_root()) return;
  const SampleResult& whole =
      test::reference([&] { return run_sample(self, parameters, parameters.output, part(self)); });
  test::expect_same_course(whole, pieces);
  const FragmentCount& last = whole.fragment_history.back();
  std::printf("%d ranks: %d pieces, %zu fragments, %ld frozen with %.3g of %.3g J, energy error %.1e\n",
              world.size(), n_pieces, whole.fragments.pieces.size(), static_cast<long>(last.frozen),
              last.frozen_energy, whole.energy.back().external, whole.energy_error);
  EXPECT_GT(n_pieces, 3);
  EXPECT_EQ(whole.outcome, Outcome::separated);
  EXPECT_EQ(whole.note, "");
  EXPECT_NEAR(whole.energy.back().time, parameters.time.duration, 1e-6);
  EXPECT_GE(last.frozen, 1);
  EXPECT_GT(last.frozen_energy, 0);
  EXPECT_LT(whole.energy_error, 1e-3);
  for (const Fragment& one : whole.fragments.pieces) EXPECT_TRUE(!one.is_frozen || one.kinetic == 0);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
