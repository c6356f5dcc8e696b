// SPDX-License-Identifier: GPL-3.0-or-later
// One sample shared by the ranks of a group: the same bits as on one rank.
#include "crackle/dynamics/sample_run.h"
#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace crackle::dynamics {
namespace {

using input::BoundaryKind;
using input::Face;

/// A bar that is torn apart from rest by a sudden traction: it breaks in many places.
input::Parameters torn_bar() {
  input::Parameters parameters;
  parameters.specimen.size = {0.002, 0.004, 0.012};
  parameters.material = test::epoxy();
  parameters.fracture = {.strength = 35e6, .exponent = 2, .impulse = 1e4};
  parameters.time.start = input::Start::rest;
  parameters.time.duration = 2.5e-5;
  parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}));
  parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::traction, {}, {0, 3e6, 22e6}));
  parameters.output.frames = 3;
  return parameters;
}

using MakePartition = std::function<geometry::Partition(const geometry::Realization& mesh, int n_parts)>;

geometry::Partition by_metis(const geometry::Realization& mesh, int n_parts) {
  return geometry::partition(mesh, n_parts);
}

/// The sample on all ranks and on one: equal to the last bit.
void compare(const input::Parameters& parameters, std::size_t least_breaks,
             const MakePartition& make_partition = by_metis) {
  const auto mesh =
      test::make_box({.size = parameters.specimen.size, .cells = {3, 5, 14}, .disturbance = 0.2});
  const parallel::Communicator world(MPI_COMM_WORLD);
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto partition = make_partition(mesh, world.size());
  const auto parts = geometry::split(mesh, partition);
  const auto shared = run_sample(world, parameters, parts[static_cast<std::size_t>(world.rank())]);
  if (!world.is_root()) return;
  const auto alone = run_sample(self, parameters, test::whole(mesh));

  const auto part_of = [&](const fracture::Break& record) {
    return partition.tetrahedron_part[static_cast<std::size_t>(record.tetrahedron)];
  };
  const auto breaks_elsewhere =
      std::ranges::count_if(alone.breaks, [&](const auto& record) { return part_of(record) != 0; });
  std::printf(
      "%d ranks: %zu breaks, %ld of them on others than the first, %ld cut faces, %s, energy error %.1e, "
      "%lld restarts\n",
      world.size(), shared.breaks.size(), static_cast<long>(breaks_elsewhere),
      static_cast<long>(geometry::edge_cut(mesh, partition)), to_string(shared.outcome).c_str(),
      shared.energy_error, static_cast<long long>(shared.counts.range_restarts));
  ASSERT_GT(alone.breaks.size(), least_breaks) << "the case must break";
  EXPECT_EQ(shared.stable_step, alone.stable_step);
  EXPECT_EQ(shared.onset_force, alone.onset_force);
  EXPECT_EQ(shared.counts.solver_iterations, alone.counts.solver_iterations);
  EXPECT_EQ(shared.counts.range_restarts, alone.counts.range_restarts);
  EXPECT_EQ(shared.outcome, alone.outcome);
  ASSERT_EQ(shared.breaks.size(), alone.breaks.size());
  for (std::size_t i = 0; i < alone.breaks.size(); ++i) {
    EXPECT_EQ(shared.breaks[i].tetrahedron, alone.breaks[i].tetrahedron);
    EXPECT_EQ(shared.breaks[i].phase_time, alone.breaks[i].phase_time);
    EXPECT_EQ(shared.breaks[i].released_energy, alone.breaks[i].released_energy);
    EXPECT_EQ(shared.breaks[i].cut, alone.breaks[i].cut);
  }
  EXPECT_EQ(alone.ties.empty(), parameters.fracture.release == input::Release::element);
  ASSERT_EQ(shared.ties.size(), alone.ties.size());
  for (std::size_t i = 0; i < alone.ties.size(); ++i) {
    EXPECT_EQ(shared.ties[i].tetrahedron, alone.ties[i].tetrahedron);
    EXPECT_EQ(shared.ties[i].load_time, alone.ties[i].load_time);
    EXPECT_EQ(shared.ties[i].phase_time, alone.ties[i].phase_time);
    EXPECT_EQ(shared.ties[i].released_energy, alone.ties[i].released_energy);
    EXPECT_EQ(shared.ties[i].edges, alone.ties[i].edges);
  }
  ASSERT_EQ(shared.energy.size(), alone.energy.size());
  for (std::size_t i = 0; i < alone.energy.size(); ++i) {
    EXPECT_EQ(shared.energy[i].kinetic, alone.energy[i].kinetic);
    EXPECT_EQ(shared.energy[i].strain, alone.energy[i].strain);
    EXPECT_EQ(shared.energy[i].external, alone.energy[i].external);
    EXPECT_EQ(shared.energy[i].released, alone.energy[i].released);
  }
  ASSERT_EQ(shared.frames.size(), alone.frames.size());
  for (std::size_t i = 0; i < alone.frames.size(); ++i) {
    EXPECT_EQ(shared.frames[i].displacement, alone.frames[i].displacement);
    EXPECT_EQ(shared.frames[i].velocity, alone.frames[i].velocity);
  }
}

class SampleOnManyRanks : public ::testing::TestWithParam<input::Precision> {};

TEST_P(SampleOnManyRanks, HasTheBitsOfOneRank) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  compare(parameters, 50);
}

TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankFromQuasiStaticLoadingOn) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.time.start = input::Start::quasi_static;
  parameters.boundaries.back() = test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10});
  compare(parameters, 20);
}

/// Facets and the tie rule, whose edges may lie between two ghosts, and a strength that differs from one
/// tetrahedron to the next.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankWithFacetsAndToughness) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.fracture.release = input::Release::facet;
  parameters.fracture.strength = 0;
  parameters.fracture.toughness = 70;
  compare(parameters, 50);
  parameters.time.start = input::Start::quasi_static;
  parameters.boundaries.back() = test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10});
  compare(parameters, 20);
}

/// Parts that a partitioner would not make. The bar breaks across its axis, and part by part along it.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankForAnyPartition) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  const auto by_position = [](const std::function<int(const geometry::Point&, std::size_t, int)>& part) {
    return [part](const geometry::Realization& mesh, int n_parts) {
      std::vector<std::int32_t> parts;
      for (const auto& t : mesh.tetrahedra) {
        geometry::Point centre{};
        for (const auto node : t)
          for (std::size_t i = 0; i < 3; ++i)
            centre[i] += 0.25 * mesh.nodes[static_cast<std::size_t>(node)][i];
        parts.push_back(part(centre, parts.size(), n_parts));
      }
      return geometry::partition_of(mesh, std::move(parts), n_parts);
    };
  };
  const auto slab = [&parameters](const geometry::Point& p, std::size_t axis, int n) {
    return std::min(n - 1, static_cast<int>(n * p[axis] / parameters.specimen.size[axis]));
  };
  const struct {
    const char* name;
    MakePartition make;
  } cases[] = {
      {"across the axis", by_position([&](const auto& p, std::size_t, int n) { return slab(p, 2, n); })},
      {"along the axis", by_position([&](const auto& p, std::size_t, int n) { return slab(p, 1, n); })},
      {"disconnected", by_position([&](const auto& p, std::size_t, int n) { return slab(p, 2, 14) % n; })},
      {"scattered", by_position([](const auto&, std::size_t t, int n) {
         auto stream = parallel::RandomStream(7, 0, "parts").substream(t);
         return std::min(n - 1, static_cast<int>(stream.uniform(0, n)));
       })},
      {"all on the last", by_position([](const auto&, std::size_t, int n) { return n - 1; })},
      {"one tetrahedron each but for the first", by_position([](const auto&, std::size_t t, int n) {
         return t < static_cast<std::size_t>(n) ? static_cast<int>(t) : 0;
       })},
      {"another seed", [](const auto& mesh, int n) { return geometry::partition(mesh, n, 1234); }},
  };
  if (GetParam() == input::Precision::mixed) {
    for (const auto& each : cases) {
      SCOPED_TRACE(each.name);
      compare(parameters, 50, each.make);
    }
    return;
  }
  parameters.time.start = input::Start::quasi_static;
  parameters.boundaries.back() = test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10});
  for (const auto& each : std::span(cases).subspan(3, 3)) {
    SCOPED_TRACE(each.name);
    compare(parameters, 20, each.make);
  }
}

/// One exchange for each drift, of three integers for each ghost: for the force after it, or for the breaking
/// check where a step ends with it.
TEST_P(SampleOnManyRanks, ExchangesGhostsOnceForEachForce) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.fracture.strength = 1e12;
  const auto mesh =
      test::make_box({.size = parameters.specimen.size, .cells = {3, 5, 14}, .disturbance = 0.2});
  const parallel::Communicator world(MPI_COMM_WORLD);
  const auto part =
      geometry::split(mesh, geometry::partition(mesh, world.size()))[static_cast<std::size_t>(world.rank())];
  for (const auto integrator : {input::Integrator::bilateral4, input::Integrator::verlet}) {
    parameters.time.integrator = integrator;
    const auto result = run_sample(world, parameters, part);
    const auto n_ghosts = static_cast<std::int64_t>(part.nodes.size()) - part.n_owned;
    const std::int64_t number = GetParam() == input::Precision::mixed ? 4 : 8;
    const auto& traffic = result.timings.traffic;
    std::printf("rank %d: %lld forces, %lld exchanges of %lld bytes for %lld ghosts\n", world.rank(),
                static_cast<long long>(result.counts.force_evaluations),
                static_cast<long long>(traffic.n_exchanges),
                static_cast<long long>(traffic.bytes_per_exchange), static_cast<long long>(n_ghosts));
    if (world.size() == 1) {
      EXPECT_EQ(traffic.n_exchanges, 0);
      continue;
    }
    EXPECT_EQ(traffic.bytes_per_exchange, 3 * number * n_ghosts);
    const std::int64_t drifts_per_step = integrator == input::Integrator::bilateral4 ? 4 : 1;
    EXPECT_EQ(traffic.n_exchanges, drifts_per_step * result.counts.steps);
    EXPECT_LE(result.counts.force_evaluations, drifts_per_step * result.counts.steps + 1);
  }
}

INSTANTIATE_TEST_SUITE_P(Precisions, SampleOnManyRanks,
                         ::testing::Values(input::Precision::mixed, input::Precision::double_),
                         [](const auto& info) {
                           return info.param == input::Precision::mixed ? "Mixed" : "Double";
                         });

}  // namespace
}  // namespace crackle::dynamics
