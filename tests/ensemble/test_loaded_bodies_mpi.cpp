// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies under every kind of load: bitwise equal on any number of ranks and after an interruption, and what
// the loads do.
#include "common/index.h"
#include "dynamics/sample_run.h"
#include "geometry/pre_crack.h"

#include "support/box_mesh.h"
#include "support/effort.h"
#include "support/group.h"
#include "support/same_result.h"
#include "support/springs.h"
#include "two_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BodyLoad;
using input::BoundaryKind;
using input::LoadKind;
using plane::Face;

/// Quenched and tempered: it breaks by stresses of its own.
input::Parameters quenched_bar(input::Release release) {
  auto parameters = test::brittle({0.004, 0.004, 0.012}, {70e9, 0.23, 2500});
  parameters.time.duration = 1e-5;
  parameters.time.arrest = 2e-6;
  parameters.output.frames = 2;
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}),
                           test::boundary(Face::z_max, BoundaryKind::fix, {true, true, true})};
  auto& quench = parameters.initial_stresses.emplace_back();
  quench.along = 0;
  quench.kind = input::InitialStressKind::temperature;
  quench.expansion = 9e-6;
  quench.temperature = {{0, -100}, {0.0015, 0}};
  quench.history = {{0, 0}, {0.4, 0.4}};
  auto& tempered = parameters.initial_stresses.emplace_back();
  tempered.along = 1;
  tempered.kind = input::InitialStressKind::surface;
  tempered.surface = -20e6;
  parameters.fracture.release = release;
  if (release == input::Release::facet) parameters.fracture.release_time = 2e-7;
  return parameters;
}

input::Parameters held_bar() {
  auto parameters = test::brittle({0.002, 0.004, 0.012});
  parameters.fracture.impulse = 1e5;
  parameters.time.precision = input::Precision::double_;
  parameters.time.integrator = input::Integrator::verlet;
  parameters.time.duration = 1e-5;
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true})};
  parameters.output.frames = 4;
  return parameters;
}

/// Everything at once: flung outwards, turning, pulled unevenly.
input::Parameters flung_bar() {
  auto parameters = held_bar();
  parameters.time.start = input::Start::rest;
  BodyLoad fling, push, turn, gravity;
  fling.kind = LoadKind::velocity_gradient;
  fling.gradient = {Vector{0, 0, 0}, {0, 0, 50}, {0, 100, 3000}};
  push.kind = LoadKind::velocity;
  push.value = {1, 2, 0};
  turn.kind = LoadKind::angular_velocity;
  turn.angular_velocity = 5e3;
  turn.axis = {1, 0.5, 0};
  turn.history = {{0, 0}, {4e-6, 1}, {1, 1}};
  gravity.value = {0, 1e5, 0};
  parameters.loads = {fling, push, turn, gravity};
  auto pull = test::boundary(Face::z_max, BoundaryKind::traction, {}, {0, 0, 5e6});
  pull.factor = {1, {{0, 0}, {0.0013, 1}, {0.004, 0.5}}};
  auto drive = test::boundary(Face::z_min, BoundaryKind::velocity, {true, true, true}, {0, 0, -2});
  drive.factor = {0, {{0, 1}, {0.002, 0.5}}};
  parameters.boundaries = {drive, pull};
  return parameters;
}

/// Hangs from its end while gravity grows.
input::Parameters hanging_bar() {
  auto parameters = held_bar();
  parameters.time.arrest = 2.5e-6;
  BodyLoad gravity;
  gravity.rate = {0, 1e4, 1e5};
  parameters.loads = {gravity};
  return parameters;
}

/// A block under a blast on part of one face, held at the opposite one: the pressure crushes the face.
input::Parameters blasted_block(input::Integrator integrator) {
  input::Parameters parameters;
  parameters.specimen.size = {0.003, 0.008, 0.012};
  parameters.materials[0] = test::epoxy();
  parameters.fracture = {.strength = 25e6, .exponent = 2, .impulse = 1e4};
  parameters.time.start = input::Start::rest;
  parameters.time.integrator = integrator;
  parameters.time.precision = input::Precision::double_;
  parameters.time.duration = 1e-5;
  parameters.time.step = 2e-8;
  auto pressure = test::boundary(Face::y_min, BoundaryKind::pressure, {}, {80e6, 0, 0});
  pressure.region[2] = {0.0035, 0.0085};
  pressure.history = {{0, 0}, {1e-6, 1}, {8e-6, 0.5}};
  parameters.boundaries = {pressure, test::boundary(Face::y_max, BoundaryKind::fix, {true, true, true})};
  parameters.output.frames = 3;
  return parameters;
}

/// Pulled at its end, part of which is a finger on a thin neck, which tears off first.
input::Parameters bar_with_finger() {
  auto parameters = blasted_block(input::Integrator::verlet);
  parameters.specimen.size = {0.003, 0.006, 0.012};
  parameters.time = {};
  parameters.time.precision = input::Precision::double_;
  parameters.time.duration = 2e-4;
  parameters.time.arrest = 5e-5;
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}),
                           test::boundary(Face::z_max, BoundaryKind::traction, {}, {}, {0, 0, 1e6})};
  return parameters;
}

/// Pulled, with a tilted elliptic crack in its middle, from which facets or whole tetrahedra break.
input::Parameters pre_cracked_bar(input::Release release) {
  auto parameters = test::brittle({0.003, 0.006, 0.012});
  parameters.fracture.toughness = 100;
  parameters.fracture.release = release;
  parameters.time.precision = input::Precision::double_;
  parameters.time.duration = 2e-5;
  parameters.time.arrest = 5e-6;
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}),
                           test::boundary(Face::z_max, BoundaryKind::traction, {}, {}, {0, 0, 1e6})};
  plane::PreCrack crack;
  crack.center = {0.0015, 0.003, 0.006};
  crack.semi_axes = {0.0011, 0.0017};
  crack.normal = {0, 0.5, 1};
  parameters.specimen.cracks = {crack};
  return parameters;
}

/// Pressed until cracks grow from an inclined one, whose sides slide with friction.
input::Parameters closing_crack() {
  auto parameters = pre_cracked_bar(input::Release::element);
  parameters.boundaries[1].rate = {0, 0, -1e6};
  parameters.specimen.cracks[0].normal = {0, 1, 1};
  parameters.contact = input::SurfaceContact{.friction = 0.2};
  return parameters;
}

/// The largest component of the load exerted by a condition.
double load(const HistoryRow& row, std::size_t condition) {
  double largest = 0;
  for (const double component : row.force[condition]) largest = std::max(largest, std::abs(component));
  return largest;
}

/// The pressure ends on fragments that fly away, and so does its work.
void expect_no_work_on_fragments(const SampleResult& result) {
  ASSERT_GT(result.breaks.size(), 100U);
  const auto at_peak =
      std::ranges::find_if(result.history, [](const HistoryRow& row) { return row.load_time >= 2e-6; });
  ASSERT_NE(at_peak, result.history.end());
  const auto& end = result.history.back();
  const double whole_load = 80e6 * 0.003 * 0.005;
  std::printf(
      "%zu breaks, external work %.3g J at 2 us, %.3g J at the end, load %.3g of %.3g N, error %.1e\n",
      result.breaks.size(), at_peak->energy.external, end.energy.external, load(end, 0), 0.5 * whole_load,
      result.energy_error);
  EXPECT_LT(end.energy.external, 6 * at_peak->energy.external) << "fragments are pushed on";
  EXPECT_LT(load(end, 0), 0.4 * whole_load);
  EXPECT_LT(result.energy_error, 1e-4);
}

void expect_quenched(const SampleResult& result) {
  EXPECT_GT(result.breaks.size(), 5U);
  EXPECT_GE(result.counts.dynamic_phases, 1);
  EXPECT_LT(result.energy_error, 1e-3);
}

void expect_flung(const SampleResult& result) {
  EXPECT_GT(result.breaks.size(), 20U);
  EXPECT_LT(result.energy_error, 0.02);
}

/// The finger tears off first, and the rest of the loading is left to the bar.
void expect_more_than_the_finger(const SampleResult& result) {
  double most = 0;
  for (const HistoryRow& row : result.history) most = std::max(most, load(row, 1));
  std::printf("first break at %.4g N, at most %.4g N\n", result.first_break_load, most);
  EXPECT_EQ(result.outcome, Outcome::separated);
  EXPECT_GT(most, 1.5 * result.first_break_load) << "the bar bears more than its finger";
  EXPECT_LT(result.energy_error, 1e-5);
}

/// Breaks where the crack ends, at a fraction of the strength.
void expect_weakened(const SampleResult& result) {
  std::printf("first break at %.4g N, %.2f of the strength\n", result.first_break_load,
              result.first_break_load / (25e6 * 0.003 * 0.006));
  EXPECT_GT(result.breaks.size(), 20U);
  EXPECT_LT(result.energy_error, 1e-3);
}

/// A ball that spins strikes a plate's middle, rubs along it, and breaks it.
input::Parameters struck_plate(input::Integrator integrator) {
  auto parameters = test::brittle({0.001, 0.006, 0.008});
  parameters.time.start = input::Start::rest;
  parameters.time.integrator = integrator;
  parameters.time.duration = 8e-6;
  parameters.fracture.impulse = 1e4;
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}),
                           test::boundary(Face::z_max, BoundaryKind::fix, {true, true, true})};
  input::Tool ball;
  ball.at = {0.00301, 0.0031, 0.0042};
  ball.radius = 0.002;
  ball.mass = 2e-5;
  ball.velocity = Vector{-20, 5, 0};
  ball.friction = 0.2;
  ball.free = {true, true, true, true, false, true};
  ball.angular_velocity = Vector{1e3, 0, 2e4};
  parameters.tools = {ball};
  return parameters;
}

void expect_struck(const SampleResult& result) {
  const ToolState& ball = result.history.back().tools.at(0);
  std::printf("the ball flies at %.4g m/s after %zu breaks, friction took %.3g uJ\n", ball.velocity[0],
              result.breaks.size(), 1e6 * ball.friction_work);
  EXPECT_GT(result.breaks.size(), 10U);
  EXPECT_GT(ball.velocity[0], -19);
  EXPECT_GT(ball.friction_work, 0);
  EXPECT_NE(ball.angular_velocity[0], 1e3);
  EXPECT_EQ(ball.angular_velocity[1], 0) << "it cannot turn about y";
  EXPECT_LT(result.energy_error, 0.02);
}

/// Pressed between rough plates by a force, then sheared by one of them.
input::Parameters pressed_block() {
  auto parameters = test::brittle({0.004, 0.006, 0.008});
  parameters.time.duration = 5e-6;
  parameters.time.arrest = 2e-6;
  input::Tool plate;
  plate.shape = input::ToolShape::plane;
  plate.axis = {0, 0, 1};
  plate.friction = 0.5;
  parameters.tools = {plate, plate};
  parameters.tools[1].axis = {0, 0, -1};
  parameters.tools[1].at = {0, 0, 0.008};
  parameters.tools[1].force = Vector{0, 100, -600};
  parameters.tools[1].history = {{0, 0}, {1, 1}};
  return parameters;
}

void expect_pressed(const SampleResult& result) {
  const ToolState &below = result.history.back().tools.at(0), &above = result.history.back().tools.at(1);
  std::printf("%.6g and %.6g N on the plates, which has moved by %.4g and %.4g um\n", below.reaction[2],
              above.reaction[2], 1e6 * above.displacement[1], 1e6 * above.displacement[2]);
  EXPECT_NEAR(above.reaction[2], -600, 0.2);
  EXPECT_NEAR(below.reaction[2], 600, 0.2);
  EXPECT_NEAR(below.reaction[1], -100, 0.2);
  EXPECT_GT(above.displacement[1], 0);
  EXPECT_LT(result.energy_error, 1e-2);
}

struct Case {
  std::string name;
  input::Parameters parameters;
  std::array<int, 3> cells;
  std::function<void(const SampleResult&)> expect;
  std::function<bool(const geometry::Point&)> removed = [](const geometry::Point&) { return false; };
  std::vector<MakeTerm> terms = {};
};

/// The finger is 1 mm wide on a neck of one cell; both it and the bar end in the loaded face.
bool is_beside_finger(const geometry::Point& p) {
  if (p[2] < 0.008 || p[1] < 0.004) return false;
  return p[1] < 0.005 || (p[2] < 0.009 && p[0] > 0.001);
}

/// The bar with a finger, along springs on one side.
Case spring_case(const char* name, test::SpringBed::Kind kind) {
  test::SpringBed bed{.kind = kind, .condition = 2, .component = 1, .stiffness = 1e7};
  if (kind == test::SpringBed::Kind::one_sided) bed.gap = 1e-6;
  auto parameters = bar_with_finger();
  parameters.boundaries.push_back(test::boundary(Face::y_min, BoundaryKind::force, {}, {}, {0, 1e-3, 0}));
  return {name,
          parameters,
          {3, 6, 12},
          [](const SampleResult& result) {
            expect_more_than_the_finger(result);
            EXPECT_GE(result.counts.dynamic_phases, 2);
            EXPECT_NE(result.history[1].records.at(0).value, 0);
          },
          is_beside_finger,
          {test::make_springs(bed)}};
}

/// Torn in two along springs, which hold what is left only sideways.
Case torn_case() {
  Case torn = spring_case("TornAlongSprings", test::SpringBed::Kind::in_increments);
  const auto springs = torn.parameters.boundaries.back();
  torn.parameters = test::pulled_bar(test::brittle({0.002, 0.004, 0.012}));
  torn.parameters.boundaries.push_back(springs);
  torn.cells = {2, 4, 10};
  torn.removed = [](const geometry::Point&) { return false; };
  torn.expect = [](const SampleResult& result) {
    EXPECT_EQ(result.outcome, Outcome::separated);
    EXPECT_EQ(result.counts.dynamic_phases, 1);
    EXPECT_LT(result.energy_error, 1e-4);
  };
  return torn;
}

std::vector<Case> cases() {
  using input::Integrator;
  using input::Release;
  return {{"Quenched", quenched_bar(Release::element), {3, 3, 9}, expect_quenched},
          {"QuenchedByFacets", quenched_bar(Release::facet), {3, 3, 9}, expect_quenched},
          {"Flung", flung_bar(), {2, 4, 10}, expect_flung},
          {"Hanging", hanging_bar(), {2, 4, 10}, expect_flung},
          {"BlastedByVerlet", blasted_block(Integrator::verlet), {4, 10, 15}, expect_no_work_on_fragments},
          {"BlastedByBilateral4",
           blasted_block(Integrator::bilateral4),
           {4, 10, 15},
           expect_no_work_on_fragments},
          {"PreCracked", pre_cracked_bar(Release::element), {4, 8, 16}, expect_weakened},
          {"ClosingCrack", closing_crack(), {3, 6, 12}, expect_weakened},
          {"PreCrackedByFacets", pre_cracked_bar(Release::facet), {4, 8, 16}, expect_weakened},
          {"StruckByBilateral4", struck_plate(Integrator::bilateral4), {2, 12, 16}, expect_struck},
          {"StruckByVerlet", struck_plate(Integrator::verlet), {2, 12, 16}, expect_struck},
          {"PressedBetweenPlates", pressed_block(), {4, 6, 8}, expect_pressed},
          {"Finger", bar_with_finger(), {3, 6, 12}, expect_more_than_the_finger, is_beside_finger},
          spring_case("OnSprings", test::SpringBed::Kind::linear),
          spring_case("OnSpringsInIncrements", test::SpringBed::Kind::in_increments),
          spring_case("AgainstAStop", test::SpringBed::Kind::one_sided),
          torn_case()};
}

class LoadedBody : public testing::TestWithParam<Case> {};

TEST_P(LoadedBody, HasTheBitsOfOneRankAlsoAfterAnInterruption) {
  const auto& [name, parameters, cells, expect, removed, terms] = GetParam();
  SampleControl control;
  control.more_terms = terms;
  auto mesh = test::make_box(
      {.size = parameters.specimen.size, .cells = cells, .disturbance = 0.2, .removed = removed});
  geometry::open_pre_cracks(parameters.specimen.cracks, {{}, parameters.specimen.size}, mesh);
  const parallel::Communicator world(test::group()), self(MPI_COMM_SELF);
  const auto part = geometry::split(mesh, geometry::partition(mesh, world.size()))[index(world.rank())];
  const auto pieces = in_two_pieces(world, parameters, parameters.output, part, control);
  // Without an interruption, whose first piece shows the same but for what follows.
  const bool is_whole = world.size() > 1 && test::is_full();
  const auto together =
      is_whole ? run_sample(world, parameters, parameters.output, part, control) : SampleResult{};
  if (!world.is_root()) return;
  const auto& alone = test::reference(
      [&] { return run_sample(self, parameters, parameters.output, test::whole(mesh), control); });
  std::printf("%s: %s after %zu breaks in %lld dynamic phases, energy error %.1e\n", name.c_str(),
              to_string(alone.outcome).c_str(), alone.breaks.size(),
              static_cast<long long>(alone.counts.dynamic_phases), alone.energy_error);
  expect(alone);
  test::expect_same_course(alone, pieces);
  if (is_whole) test::expect_same_course(alone, together);
}

INSTANTIATE_TEST_SUITE_P(Loads, LoadedBody, testing::ValuesIn(cases()),
                         [](const auto& info) { return info.param.name; });

/// The pressure on a blasted block ends on its fragments in the other engine too.
TEST(BlastedBlock, LosesItsLoadInTheOtherEngineToo) {
  auto parameters = blasted_block(input::Integrator::verlet);
  const auto mesh =
      test::make_box({.size = parameters.specimen.size, .cells = {4, 10, 15}, .disturbance = 0.2});
  const parallel::Communicator world(test::group());
  const auto part = geometry::split(mesh, geometry::partition(mesh, world.size()))[index(world.rank())];
  parameters.time.duration = 4e-6;
  const auto result = run_sample(world, parameters, parameters.output, part);
  parameters.time.engine = input::Engine::petsc;
  const auto other = run_sample(world, parameters, parameters.output, part);
  if (!world.is_root()) return;
  ASSERT_EQ(result.history.size(), other.history.size());
  const auto& end = result.history.back();
  const auto& other_end = other.history.back();
  EXPECT_LT(load(end, 0), 0.8 * 80e6 * 0.003 * 0.005);
  EXPECT_NEAR(load(end, 0), load(other_end, 0), 1e-9 * load(end, 0));
  EXPECT_NEAR(end.energy.external, other_end.energy.external, 1e-6 * end.energy.external);
  EXPECT_LT(other.energy_error, 1e-4);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
