// SPDX-License-Identifier: GPL-3.0-or-later
// One sample shared by the ranks of a group: bitwise equal to that on one rank.
#include "common/index.h"
#include "dynamics/sample_run.h"
#include "fracture/connectivity.h"
#include "geometry/point.h"
#include "geometry/realization.h"

#include "support/box_mesh.h"
#include "support/effort.h"
#include "support/group.h"
#include "support/job.h"
#include "support/partitions.h"
#include "support/plate_family.h"
#include "support/same_result.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <set>
#include <string>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

/// A bar torn apart from rest by a sudden traction: it breaks in many places.
input::Parameters torn_bar() {
  auto parameters = test::brittle({0.002, 0.004, 0.012});
  parameters.time.start = input::Start::rest;
  parameters.time.duration = 2.5e-5;
  parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}));
  parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::traction, {}, {0, 3e6, 22e6}));
  parameters.output.frames = 3;
  return parameters;
}

geometry::Partition by_metis(const geometry::Realization& mesh, int n_parts) {
  return geometry::partition(mesh, n_parts);
}

using Partitions = std::vector<test::NamedPartition>;

/// The sample on the ranks of a group against that on one rank.
void compare_on(const parallel::Communicator& world, const input::Parameters& parameters,
                const geometry::Realization& mesh, const geometry::Partition& partition,
                const dynamics::SampleResult* alone_on_root) {
  const auto parts = geometry::split(mesh, partition, parameters.fracture.length);
  const auto shared = run_sample(world, parameters, parameters.output, parts[index(world.rank())]);
  if (!world.is_root()) return;
  const dynamics::SampleResult& alone = *alone_on_root;
  const auto part_of = [&](const fracture::Break& record) {
    return partition.tetrahedron_part[index(record.tetrahedron)];
  };
  const auto breaks_elsewhere =
      std::ranges::count_if(alone.breaks, [&](const auto& record) { return part_of(record) != 0; });
  std::printf(
      "%d ranks: %zu breaks, %ld of them on others than the first, %ld cut faces, %s, energy error %.1e, "
      "%lld static solves, %lld dynamic phases, %lld restarts, %zu teeth\n",
      world.size(), shared.breaks.size(), static_cast<long>(breaks_elsewhere),
      static_cast<long>(geometry::edge_cut(mesh, partition)), to_string(shared.outcome).c_str(),
      shared.energy_error, static_cast<long long>(shared.counts.static_solves),
      static_cast<long long>(shared.counts.dynamic_phases),
      static_cast<long long>(shared.counts.range_restarts), shared.stiffness_reductions.size());
  test::expect_same_course(shared, alone);
  EXPECT_EQ(shared.counts.static_solves, alone.counts.static_solves);
  EXPECT_EQ(shared.counts.solver_iterations, alone.counts.solver_iterations);
}

/// Compares the sample on all ranks, divided among them in each of some ways, and on one: bitwise equal.
/// @return the sample on one rank; nullptr on other ranks than the root
const dynamics::SampleResult* compare(const input::Parameters& parameters, const geometry::Realization& mesh,
                                      std::size_t least_breaks,
                                      const Partitions& partitions = {{"by METIS", by_metis}}) {
  const parallel::Communicator world(test::group());
  const parallel::Communicator self(MPI_COMM_SELF);
  const dynamics::SampleResult* alone = nullptr;
  if (world.is_root()) {
    alone =
        &test::reference([&] { return run_sample(self, parameters, parameters.output, test::whole(mesh)); });
    EXPECT_GT(alone->breaks.size(), least_breaks) << "the case must break";
    EXPECT_EQ(alone->bridge_releases.empty(), parameters.fracture.release != input::Release::facet);
    EXPECT_EQ(alone->stiffness_reductions.empty(), parameters.fracture.release != input::Release::softening);
  }
  for (const auto& each : partitions) {
    SCOPED_TRACE(each.name);
    compare_on(world, parameters, mesh, each.make(mesh, world.size()), alone);
  }
  return alone;
}

/// For a box.
const dynamics::SampleResult* compare(const input::Parameters& parameters, std::size_t least_breaks,
                                      const Partitions& partitions = {{"by METIS", by_metis}}) {
  return compare(parameters,
                 test::make_box({.size = parameters.specimen.size, .cells = {3, 5, 14}, .disturbance = 0.2}),
                 least_breaks, partitions);
}

/// Two blocks of 4 x 4 x 12 mm that share a line of nodes, with or without an adjacent column.
geometry::Realization hinged_blocks(bool has_column) {
  return test::make_box(
      {.size = {0.004, 0.004, 0.012}, .cells = {4, 4, 12}, .removed = [=](const geometry::Point& p) {
         const bool is_column = has_column && p[0] > 0.001 && p[0] < 0.002 && p[1] > 0.003;
         if (is_column || p[2] < 0.004 || p[2] > 0.008) return false;
         return p[2] < 0.006 ? p[1] > 0.001 : p[1] < 0.001;
       }});
}

/// The upper block is driven along one edge: nothing resists once the column is broken.
TEST(HingeOnManyRanks, EndsTheSampleAsOnOneRank) {
  auto parameters = torn_bar();
  parameters.specimen.size = {0.004, 0.004, 0.012};
  parameters.time.start = input::Start::quasi_static;
  parameters.time.arrest = 1e-30;
  parameters.boundaries.back() =
      test::boundary(Face::z_max, BoundaryKind::displacement, {false, false, true}, {}, {0, 0, 1e-6});
  parameters.boundaries.back().region[1] = {0.0035, 0.0045};
  const auto* alone = compare(parameters, hinged_blocks(true), 0);
  if (!alone) return;
  EXPECT_EQ(alone->outcome, Outcome::separated);
  EXPECT_EQ(alone->history.back().load_time, alone->breaks.back().load_time);
}

TEST(FacePieces, AreTheSameOnManyRanksAndEndAtAHinge) {
  const parallel::Communicator world(test::group()), self(MPI_COMM_SELF);
  const auto mesh = hinged_blocks(false);
  const auto whole = test::whole(mesh);
  const fracture::BreakableBody intact(whole, test::epoxy());
  const auto expected = fracture::face_piece_labels(self, intact);
  EXPECT_EQ(std::set(expected.begin(), expected.end()).size(), 2U);
  const auto by_edges = fracture::piece_labels(self, intact);
  EXPECT_EQ(std::set(by_edges.begin(), by_edges.end()).size(), 1U);
  const auto parts = geometry::split(mesh, by_metis(mesh, world.size()));
  const auto& part = parts[index(world.rank())];
  const fracture::BreakableBody body(part, test::epoxy());
  const auto labels = fracture::face_piece_labels(world, body);
  for (std::size_t t = 0; t < labels.size(); ++t)
    EXPECT_EQ(labels[t], expected[index(part.tetrahedron_number[t])]);
}

class SampleOnManyRanks : public ::testing::TestWithParam<input::Precision> {
protected:
  void SetUp() override {
    if (parallel::Communicator(test::group()).size() == 1) GTEST_SKIP() << "compared with itself";
    if (GetParam() == input::Precision::mixed || test::is_full()) return;
    // The numbers are those of the kernels and sums, whatever the terms add to them.
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    for (const char* const one : {"OneRank/", "OneRankForAnyPartition/", "OneRankWithContact/"})
      if (name.find(one) != name.npos) return;
    GTEST_SKIP() << "in mixed numbers only";
  }
};

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

/// A ring under internal pressure, pulled by a pin in another hole.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankOnAPlateOfAnyOutline) {
  test::PlateText text{R"(thickness = "2 mm"
outline = "circle"
radius = "6 mm")"};
  text.holes = {R"(center = ["7 mm", "6.5 mm"]
radius = "3 mm")",
                R"(center = ["2 mm", "6 mm"]
radius = "0.8 mm")"};
  text.section = "11 mm";
  text.boundaries = R"([[boundary]]
on = "edge-0"
region = { y = ["11 mm", "12 mm"] }
fix = ["x", "y", "z"]
[[boundary]]
on = "hole-0"
pressure = "1 MPa"
rate = "1 MPa/s"
[[boundary]]
on = "hole-1"
region = { y = ["0 mm", "2 mm"] }
force = ["0 N", "-1 N", "0.5 N"]
rate = ["0 N/s", "-1 N/s", "0 N/s"]
)";
  auto parameters = input::parse(text.text(), "ring.toml");
  parameters.time.precision = GetParam();
  parameters.time.duration = 1e-5;
  parameters.seed = 1;
  compare(parameters, test::realization(parameters), 20);
}

/// Balls that extend across several parts, and from one end of a part to the other.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankWithAveragedStress) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.fracture.length = 1.5e-3;
  compare(parameters, 50);
  parameters.time.start = input::Start::quasi_static;
  parameters.boundaries.back() = test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10});
  compare(parameters, 20, {test::hostile_partitions(parameters.specimen.size)[2]});
}

/// Teeth that fall one by one, in equilibria and in dynamics.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankWithSoftening) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.fracture.release = input::Release::softening;
  parameters.fracture.toughness = 900;
  parameters.fracture.teeth = 5;
  compare(parameters, 20);
  parameters.fracture.softening = input::SofteningCurve::exponential;
  parameters.fracture.toughness = 450;
  parameters.time.start = input::Start::quasi_static;
  parameters.boundaries.back() = test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0.5, 10});
  compare(parameters, 20, {test::hostile_partitions(parameters.specimen.size)[2]});
}

/// Tetrahedra that lose their stiffness over many steps, and strengths that change where a break comes near:
/// also at nodes of which a rank does not hold the broken tetrahedron. Elsewhere means around nodes, which
/// several ranks own of one tetrahedron, decide, or the own stress alone.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankWithReleaseInTimeAndNucleation) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.fracture.release_time = 3e-7;
  parameters.fracture.strength = 45e6;
  parameters.fracture.toughness = 50;
  compare(parameters, 50);
  parameters.fracture.nucleation = input::Nucleation::own_stress;
  compare(parameters, 50);
  parameters.fracture.nucleation = input::Nucleation::nodal_mean;
  parameters.fracture.release_time = {};
  parameters.fracture.release_speed = 2000;
  compare(parameters, 50);
  parameters.fracture.release = input::Release::facet;
  parameters.fracture.strength = 12e6;  // less than at cracks
  compare(parameters, 50, {test::hostile_partitions(parameters.specimen.size)[2]});
  parameters.time.start = input::Start::quasi_static;
  parameters.boundaries.back() = test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10});
  compare(parameters, 20, {test::hostile_partitions(parameters.specimen.size)[2]});
}

/// A random field of the strength, with and without a correlation length.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankWithAVaryingStrength) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.fracture.variation = {
      .distribution = input::Distribution::weibull, .modulus = 6, .reference_volume = 1e-9};
  compare(parameters, 50);
  parameters.fracture.variation = {.of = input::Varies::toughness,
                                   .distribution = input::Distribution::lognormal,
                                   .coefficient_of_variation = 0.3,
                                   .correlation_length = 1e-3};
  compare(parameters, 50);
}

/// Layers of two materials with an interface, a raster's factors and varying stiffness: parts that are
/// uniform have neighbours that are not.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankWithSeveralMaterials) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.materials = {{3300e6, 0.38, 1180, "epoxy"}, {9000e6, 0.1, 2500, "filled"}};
  parameters.materials[1].strength = 40e6;
  parameters.materials[1].impulse = 3e4;
  parameters.materials[1].release_time = 3e-7;
  parameters.interfaces = {{{"filled", "epoxy"}, 30e6, 0}};
  auto mesh = test::make_box({.size = parameters.specimen.size, .cells = {3, 5, 14}, .disturbance = 0.2});
  for (const auto& t : mesh.tetrahedra)
    mesh.material.push_back(geometry::centroid(mesh.nodes, t)[2] > 0.005 ? 1 : 0);
  mesh.interface = geometry::interface_numbers(mesh, parameters.interface_pairs());
  EXPECT_GT(std::ranges::count(mesh.interface, 1), 50);
  compare(parameters, mesh, 50);
  parameters.fracture.variation = {
      .distribution = input::Distribution::weibull, .modulus = 10, .correlation_length = 1e-3};
  parameters.materials[0].variation = {.of = input::StiffnessVaries::both,
                                       .coefficient_of_variation = 0.3,
                                       .correlation_length = 1e-3,
                                       .with_strength = 0.5};
  parameters.fracture.release_speed = 2000;  // of the first material
  parameters.map.emplace().of = input::MapOf::stiffness_and_strength;
  for (const auto& t : mesh.tetrahedra)
    mesh.map_factor.push_back(geometry::centroid(mesh.nodes, t)[1] > 0.002 ? 1.25F : 1.0F);
  parameters.time.start = input::Start::quasi_static;
  parameters.fracture.release = input::Release::facet;
  parameters.boundaries.back() = test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10});
  compare(parameters, mesh, 20, {test::hostile_partitions(parameters.specimen.size)[2]});
}

/// Dashpots at nodes shared by several parts, and damping of all of them.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankWithDampingAndAbsorbingFaces) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.time.integrator = input::Integrator::verlet;
  parameters.damping = {.mass = 1e4};
  for (const Face face : {Face::x_min, Face::y_max}) {
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::absorbing));
    parameters.boundaries.back().region[2] = {0, 0.004};
  }
  if (const auto* alone = compare(parameters, 50)) {
    EXPECT_GT(alone->energy.back().dissipated, 0.05 * alone->energy.back().external);
    EXPECT_LT(alone->energy_error, 0.02);
  }
  parameters.time.start = input::Start::quasi_static;
  parameters.boundaries[1] = test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10});
  compare(parameters, 20, {test::hostile_partitions(parameters.specimen.size)[2]});
}

/// Viscous forces of tetrahedra shared by several parts, and on driven nodes.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankWithBulkViscosity) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.damping = {.mass = 0, .bulk = {0.3, 1.2}};
  for (const auto integrator : {input::Integrator::bilateral4, input::Integrator::verlet}) {
    parameters.time.integrator = integrator;
    const auto* alone = compare(parameters, 50);
    if (alone == nullptr) continue;
    EXPECT_GT(alone->energy.back().dissipated, 0.003 * alone->energy.back().external);
    EXPECT_LT(alone->energy_error, 0.02);
  }
}

/// Masses of nodes at the parts' boundaries, and which nodes they are raised at.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankWithMassScaling) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.time.mass_scaling = 0.005;
  for (const auto integrator : {input::Integrator::bilateral4, input::Integrator::verlet}) {
    parameters.time.integrator = integrator;
    const auto* alone = compare(parameters, 50);
    if (alone == nullptr) continue;
    EXPECT_GT(alone->mass_scaling.value().gain, 1.02);
    EXPECT_LT(alone->energy_error, 0.02);
  }
  parameters.contact = input::SurfaceContact{.friction = 0.3};
  parameters.damping = {.mass = 0, .bulk = {0.06, 1.2}};
  compare(parameters, 50, {test::hostile_partitions(parameters.specimen.size)[2]});
}

/// Release by facets with the bridging rule, whose edges may lie between two ghosts, and a strength that
/// varies between tetrahedra.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankWithFacetsAndToughness) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.fracture.release = input::Release::facet;
  parameters.fracture.strength = 0;
  parameters.fracture.toughness = 124;
  compare(parameters, 50);
  parameters.time.start = input::Start::quasi_static;
  parameters.boundaries.back() = test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10});
  compare(parameters, 20);
}

/// Opened facets that close again when the bar is pushed together.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankWithContact) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.fracture.release = input::Release::facet;
  parameters.fracture.contact = input::Contact::frictionless;
  parameters.boundaries.back().value = {0, 3e6, 30e6};
  parameters.boundaries.back().history = {{0, 1}, {8e-6, 1}, {1e-5, -1}, {1, -1}};
  compare(parameters, 50);
}

/// A bar crushed to rubble, whose pieces meet, stick and slide: in one piece at first, and in two that meet.
/// Each of the two with both kinds of release under tools/check --full.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankAsRubble) {
  for (const auto release : {input::Release::element, input::Release::facet}) {
    auto parameters = torn_bar();
    parameters.time.precision = GetParam();
    parameters.fracture.release = release;
    parameters.contact = input::SurfaceContact{.friction = 0.3};
    parameters.boundaries = {
        test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}),
        test::boundary(Face::z_max, BoundaryKind::velocity, {true, true, true}, {5, 0, -60})};
    const bool is_by_facets = release == input::Release::facet;
    if (!is_by_facets || test::is_full()) compare(parameters, 50);
    if (!is_by_facets && !test::is_full()) continue;
    const auto& size = parameters.specimen.size;
    const auto in_two = test::make_box(
        {.size = size, .cells = {3, 5, 45}, .disturbance = 0.2, .removed = [&](const geometry::Point& p) {
           return std::abs(p[2] - size[2] / 2) < size[2] / 90;
         }});
    const auto cases = test::hostile_partitions(size);
    parameters.boundaries.back().value = {0, 0, -12};
    parameters.time.duration = 3e-5;
    compare(parameters, in_two, 50, {cases.begin(), cases.begin() + 2});
  }
}

/// Partitions that no partitioner would make. The bar breaks across its axis, and part by part along it.
TEST_P(SampleOnManyRanks, HasTheBitsOfOneRankForAnyPartition) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  const auto cases = test::hostile_partitions(parameters.specimen.size);
  if (GetParam() == input::Precision::mixed) {
    compare(parameters, 50, {cases.begin(), cases.end()});
    return;
  }
  parameters.time.start = input::Start::quasi_static;
  parameters.boundaries.back() = test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10});
  compare(parameters, 20, {cases.begin() + 3, cases.begin() + 6});
}

/// Loading that is resumed many times: many static solves, mostly of a partly broken body, whose break times
/// depend on what all ranks have evaluated.
class SampleInManyPhases : public ::testing::TestWithParam<int> {
protected:
  void SetUp() override {
    if (parallel::Communicator(test::group()).size() == 1) GTEST_SKIP() << "compared with itself";
  }
};

input::Parameters in_many_phases(int number) {
  auto parameters = torn_bar();
  parameters.time.start = input::Start::quasi_static;
  parameters.time.duration = 1.2e-5;
  parameters.time.arrest = 1.5e-6;
  parameters.boundaries.pop_back();
  auto& boundaries = parameters.boundaries;
  switch (number) {
    case 0:  // one load, and a strength that varies between tetrahedra
      boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0.3, 10}));
      parameters.fracture.strength = 0;
      parameters.fracture.toughness = 117;
      break;
    case 1:  // facets, two loads, one of them with kinks
      boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::force, {}, {0, 0, 40}));
      boundaries.back().history = {{0, 0}, {7, 1}, {11, 0.9}, {90, 8}};
      boundaries.push_back(test::boundary(Face::y_max, BoundaryKind::traction, {}, {}, {1e3, -2e4, 1e3}));
      parameters.fracture.release = input::Release::facet;
      break;
    case 2:  // bent between two walls: cracks that arrest
      boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::fix, {true, true, true}));
      boundaries.push_back(
          test::boundary(Face::y_max, BoundaryKind::velocity, {false, true, false}, {0, -1e-6, 0}));
      boundaries.back().region[2] = {0.005, 0.007};
      parameters.fracture.accumulation = input::Accumulation::step;
      break;
    default:  // the same by facets, with toughness and a longitudinal force
      boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::fix, {true, true, true}));
      boundaries.push_back(
          test::boundary(Face::y_max, BoundaryKind::displacement, {false, true, false}, {}, {0, -1e-6, 0}));
      boundaries.back().region[2] = {0.005, 0.007};
      boundaries.push_back(test::boundary(Face::x_max, BoundaryKind::force, {}, {}, {0.02, 0, 0.01}));
      parameters.fracture.release = input::Release::facet;
      parameters.fracture.strength = 0;
      parameters.fracture.toughness = 124;
  }
  return parameters;
}

TEST_P(SampleInManyPhases, HasTheBitsOfOneRank) {
  const auto parameters = in_many_phases(GetParam());
  const auto hostile = test::hostile_partitions(parameters.specimen.size);
  // Bent bodies take a hundred static solves: one partition each, other than METIS's, is enough for them.
  const bool is_bent = GetParam() >= 2;
  Partitions cases = {hostile[is_bent ? index(GetParam()) : 2]};
  if (!is_bent) cases.insert(cases.end(), {{"by METIS", by_metis}, hostile[3]});
  if (const auto* alone = compare(parameters, 20, cases)) {
    EXPECT_GT(alone->counts.static_solves, 3);
    EXPECT_GT(alone->counts.dynamic_phases, GetParam() < 2 ? 0 : 3);
  }
}

INSTANTIATE_TEST_SUITE_P(Loads, SampleInManyPhases, ::testing::Range(0, 4));

/// One exchange per drift, of three integers per ghost: for the following force, or for the breaking check at
/// the end of a step.
TEST_P(SampleOnManyRanks, ExchangesGhostsOnceForEachForce) {
  auto parameters = torn_bar();
  parameters.time.precision = GetParam();
  parameters.fracture.strength = 1e12;
  const auto mesh =
      test::make_box({.size = parameters.specimen.size, .cells = {3, 5, 14}, .disturbance = 0.2});
  const parallel::Communicator world(test::group());
  const auto part = geometry::split(mesh, geometry::partition(mesh, world.size()))[index(world.rank())];
  for (const auto integrator : {input::Integrator::bilateral4, input::Integrator::verlet}) {
    parameters.time.integrator = integrator;
    const auto result = run_sample(world, parameters, parameters.output, part);
    const auto n_ghosts = static_cast<std::int64_t>(part.nodes.size()) - part.layout.n_owned;
    const std::int64_t number = GetParam() == input::Precision::mixed ? 4 : 8;
    const auto& exchange_cost = result.timings.exchange_cost;
    std::printf("rank %d: %lld forces, %lld exchanges of %lld bytes for %lld ghosts\n", world.rank(),
                static_cast<long long>(result.counts.force_evaluations),
                static_cast<long long>(exchange_cost.n_exchanges),
                static_cast<long long>(exchange_cost.bytes_per_exchange), static_cast<long long>(n_ghosts));
    EXPECT_EQ(exchange_cost.bytes_per_exchange, 3 * number * n_ghosts);
    const std::int64_t drifts_per_step = integrator == input::Integrator::bilateral4 ? 4 : 1;
    EXPECT_EQ(exchange_cost.n_exchanges, drifts_per_step * result.counts.steps);
    EXPECT_LE(result.counts.force_evaluations, drifts_per_step * result.counts.steps + 1);
  }
}

INSTANTIATE_TEST_SUITE_P(Precisions, SampleOnManyRanks,
                         ::testing::Values(input::Precision::mixed, input::Precision::double_),
                         [](const auto& info) {
                           return info.param == input::Precision::mixed ? "Mixed" : "Double";
                         });

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
