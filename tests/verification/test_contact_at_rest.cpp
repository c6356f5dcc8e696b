// SPDX-License-Identifier: GPL-3.0-or-later
// Equilibria in which the sides of a crack touch: stiffness, sliding and sticking, the stress intensity of a
// crack under compression, a bent beam whose crack closes, and the start of motion.
#include "common/index.h"
#include "dynamics/quasi_static.h"
#include "dynamics/sample_run.h"
#include "dynamics/sample_setup.h"
#include "geometry/pre_crack.h"

#include "support/box_mesh.h"
#include "support/job.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

constexpr double mm = 1e-3, modulus = 3300e6;

/// The equilibria of a box with cracks up to the end of its loads.
struct Loaded {
  std::vector<LoadState> states;
  std::vector<double> displacement;
  EnergyRow energy{};
  double residual = 0;
  std::int64_t n_solves = 0;
  bool has_contact = false;
};

Loaded load(const input::Parameters& parameters, const geometry::Subdomain& subdomain) {
  const parallel::Communicator self(MPI_COMM_SELF);
  SampleSetup setup(self, parameters, subdomain, 0);
  EnergyAccount account(self, setup.body);
  QuasiStaticLoading loading(setup.motion_context(), 1e-5);
  loading.load_at_start(account);
  Loaded loaded;
  EXPECT_EQ(loading.advance(account, {}, [&](const LoadState& state) { loaded.states.push_back(state); }),
            QuasiStaticEnd::no_load);
  const auto u = loading.displacement().owned();
  loaded.displacement.assign(u.begin(), u.end());
  loaded.energy = account.row(0, {.strain = loading.strain_energy()});
  loaded.residual = loading.residual();
  loaded.n_solves = loading.n_solves();
  loaded.has_contact = loading.has_contact();
  return loaded;
}

geometry::Subdomain cracked(const input::Parameters& parameters, const test::BoxMesh& box) {
  auto mesh = test::make_box(box);
  geometry::open_pre_cracks(parameters.specimen.cracks, {{}, parameters.specimen.size}, mesh);
  return test::whole(mesh);
}

plane::PreCrack crack_along(const std::array<double, 2>& from, const std::array<double, 2>& to) {
  plane::PreCrack crack;
  crack.line = {{{from[0], from[1]}, {to[0], to[1]}}};
  return crack;
}

/// A block that a crack cuts in two, or that is whole: its upper end is pressed down, and moved aside.
double reaction(bool is_cut, std::optional<double> friction, double aside, int component, bool is_held) {
  auto parameters = test::brittle({3 * mm, 3 * mm, 6 * mm});
  parameters.fracture.strength = 1e12;
  if (is_cut) parameters.specimen.cracks = {crack_along({-1 * mm, 2.9 * mm}, {4 * mm, 2.9 * mm})};
  if (friction) parameters.contact = input::SurfaceContact{.friction = *friction};
  auto moved =
      test::boundary(Face::z_max, BoundaryKind::displacement, {is_held, true, true}, {0, aside, -6e-6});
  moved.history = {{0, 0}, {1, 1}};
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {is_held, is_held, true}), moved};
  if (!is_held) {
    parameters.boundaries.push_back(test::boundary(Face::x_min, BoundaryKind::fix, {true, false, false}));
    parameters.boundaries.push_back(test::boundary(Face::y_min, BoundaryKind::fix, {false, true, false}));
    parameters.boundaries[1].components = {false, false, true};
  }
  const auto loaded =
      load(parameters,
           cracked(parameters, {.size = parameters.specimen.size, .cells = {4, 4, 8}, .disturbance = 0.2}));
  EXPECT_LT(loaded.residual, 1e-4);
  return loaded.states.back().conditions[1].reaction[index(component)];
}

TEST(ContactAtRest, AClosedCrackIsAsStiffAsTheBlock) {
  const double whole = reaction(false, {}, 0, 2, false), cut = reaction(true, 0.0, 0, 2, false);
  std::printf("pressed across a crack: %.6f of the uncracked block's force\n", cut / whole);
  EXPECT_NEAR(cut / whole, 1, 1e-3);
}

TEST(ContactAtRest, ACrackSlidesOrSticks) {
  const double aside = 12e-6;
  const double whole = reaction(false, {}, aside, 1, true), pressure = reaction(false, {}, aside, 2, true);
  for (const double friction : {0.0, 0.1, 2.0}) {
    const double shear = reaction(true, friction, aside, 1, true) / whole;
    const double expected = std::min(1.0, friction * std::abs(pressure / whole));
    std::printf("sheared under pressure, friction %.1f: %.4f of the uncracked block's force (%.4f)\n",
                friction, shear, expected);
    EXPECT_NEAR(shear, expected, 0.02);
  }
}

/// A plate under compression with an inclined crack: the mean of the sliding along the crack over that of a
/// crack under the shear alone.
double sliding(std::optional<double> friction) {
  constexpr double a = 4 * mm, stress = 10e6;
  auto parameters = test::brittle({1 * mm, 24 * mm, 36 * mm});
  parameters.seed = 3;
  parameters.fracture.strength = 1e12;
  parameters.mesh.spacing = parameters.mesh.notch_spacing = 2 * mm;
  parameters.mesh.growth = 0.3;
  parameters.mesh.perturbation = 0.2;
  parameters.mesh.regions = {{{{{}, {8 * mm, 16 * mm}, {14 * mm, 22 * mm}}}, 0.4 * mm}};
  const double half = a / std::sqrt(2.0);
  parameters.specimen.cracks = {
      crack_along({12 * mm - half, 18 * mm - half}, {12 * mm + half, 18 * mm + half})};
  if (friction) parameters.contact = input::SurfaceContact{.friction = *friction};
  const auto hold = [&](const std::array<bool, 3>& components, double z) {
    parameters.boundaries.push_back(test::boundary(Face::y_min, BoundaryKind::fix, components));
    parameters.boundaries.back().region[2] = {z, z};
  };
  for (const double end : {0.0, parameters.specimen.size[2]}) hold({true, true, false}, end);
  hold({false, false, true}, 18 * mm);
  for (const auto& [face, sign] : {std::pair{Face::z_min, 1.0}, {Face::z_max, -1.0}}) {
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::traction, {}, {0, 0, sign * stress}));
    parameters.boundaries.back().history = {{0, 0}, {1, 1}};
  }
  auto mesh = test::realization(parameters);
  geometry::open_pre_cracks(parameters.specimen.cracks, {{}, parameters.specimen.size}, mesh);
  const auto subdomain = test::whole(mesh);
  const auto loaded = load(parameters, subdomain);
  EXPECT_EQ(loaded.has_contact, friction.has_value());
  // The jump of tetrahedra across the crack, less the shear of the body on that way.
  const auto along = [](const double* v) { return (v[1] + v[2]) / std::sqrt(2.0); };
  const auto height = [](const double* v) { return (v[2] - v[1]) / std::sqrt(2.0); };
  double sum = 0, number = 0;
  for (std::size_t t = 0; t < subdomain.tetrahedra.size(); ++t) {
    if (subdomain.pre_crack[t] == 0) continue;
    std::array<std::array<double, 2>, 2> side{};  // sums of motion and number, below and above
    for (const auto node : subdomain.tetrahedra[t]) {
      geometry::Point place = subdomain.nodes[index(node)];
      place[1] -= 12 * mm, place[2] -= 18 * mm;
      auto& one = side[height(place.data()) >= 0 ? 1 : 0];
      one[0] += along(&loaded.displacement[index(node, 0)]);
      one[1] += 1;
    }
    sum += side[1][0] / side[1][1] - side[0][0] / side[0][1];
    number += 1;
  }
  const double exact = std::numbers::pi * (stress / 2) * a / modulus;
  return std::abs(sum / number) / exact;
}

TEST(ContactAtRest, AnInclinedCrackHasTheStressIntensityOfItsFriction) {
  const double open = sliding({}), smooth = sliding(0.0), rough = sliding(0.3), stuck = sliding(2.0);
  // The layer of tetrahedra around the crack is sheared by what friction carries.
  const double less = rough - 0.3 * stuck;
  std::printf(
      "crack at 45 degrees under compression, sliding over that of tau alone in an infinite plate: %.3f "
      "without contact, %.3f without friction, %.3f with 0.3, %.3f with 2; K_II over tau sqrt(pi a): %.3f "
      "(1), "
      "%.3f (0.7)\n",
      open, smooth, rough, stuck, smooth / open, less / open);
  EXPECT_NEAR(smooth / open, 1, 0.05);
  EXPECT_NEAR(less / open, 0.7, 0.05);
  EXPECT_LT(stuck, 0.08);
}

/// A beam with a crack in its lower half is bent to one side, then to the other.
TEST(ContactAtRest, ABeamIsStiffWhereItsCrackCloses) {
  auto parameters = test::brittle({2 * mm, 6 * mm, 30 * mm});
  parameters.fracture.strength = 1e12;
  auto bent = test::boundary(Face::z_max, BoundaryKind::force, {}, {0, -2, 0});
  bent.history = {{0, 0}, {1, 1}, {3, -1}};
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}), bent};
  const test::BoxMesh box{.size = parameters.specimen.size, .cells = {2, 6, 30}, .disturbance = 0.2};
  const auto compliances = [&] {
    const auto loaded = load(parameters, cracked(parameters, box));
    const auto& states = loaded.states;
    const auto opened =
        std::ranges::min_element(states, {}, [](const auto& s) { return s.conditions[1].applied[1]; });
    const auto of = [](const LoadState& s) {
      return s.conditions[1].displacement[1] / s.conditions[1].applied[1];
    };
    const double error = (loaded.energy.external - loaded.energy.strain) / loaded.energy.strain;
    return std::array{of(*opened), of(states.back()), error, static_cast<double>(loaded.n_solves)};
  };
  const auto whole = compliances();
  parameters.specimen.cracks = {crack_along({3 * mm, 6.5 * mm}, {7 * mm, 6.5 * mm})};
  const auto without = compliances();
  parameters.fracture.contact = input::Contact::frictionless;
  const auto with = compliances();
  std::printf(
      "bent beam, compliance over the uncracked one's: crack open %.5f (without contact %.5f), closed %.5f; "
      "energy error %.1e, %.0f solves\n",
      with[0] / whole[0], without[0] / whole[0], with[1] / whole[1], with[2], with[3]);
  EXPECT_EQ(with[0], without[0]);
  EXPECT_GT(with[0], 1.1 * whole[0]);
  EXPECT_NEAR(with[1] / whole[1], 1, 0.02);
  EXPECT_LT(std::abs(with[2]), 1e-3);
}

/// A crack that opens.
TEST(ContactAtRest, LeavesAnOpenCrackAsItIs) {
  auto parameters = test::brittle({2 * mm, 4 * mm, 8 * mm});
  parameters.fracture.strength = 1e12;
  auto pulled = test::boundary(Face::z_max, BoundaryKind::traction, {}, {0, 0, 1e6});
  pulled.history = {{0, 0}, {1, 1}};
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}), pulled};
  parameters.specimen.cracks = {crack_along({-1 * mm, 4.5 * mm}, {2 * mm, 4.5 * mm})};
  const auto subdomain =
      cracked(parameters, {.size = parameters.specimen.size, .cells = {2, 4, 8}, .disturbance = 0.2});
  const auto without = load(parameters, subdomain);
  parameters.fracture.contact = input::Contact::frictionless;
  const auto with = load(parameters, subdomain);
  EXPECT_FALSE(with.has_contact);
  EXPECT_EQ(with.displacement, without.displacement);
}

/// A block with an edge crack is pressed and sheared, and set free to move.
TEST(ContactAtRest, MotionStartsWithoutAJump) {
  for (const double friction : {0.0, 0.2}) {
    auto parameters = test::brittle({3 * mm, 3 * mm, 6 * mm});
    parameters.fracture.strength = 1e12;
    parameters.contact = input::SurfaceContact{.friction = friction};
    parameters.specimen.cracks = {crack_along({-1 * mm, 2.9 * mm}, {2 * mm, 2.9 * mm})};
    parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}),
                             test::boundary(Face::z_max, BoundaryKind::traction, {}, {0, 3e6, -10e6})};
    parameters.time.start = input::Start::equilibrium;
    parameters.time.precision = input::Precision::double_;
    parameters.time.duration = 1e-5;
    const parallel::Communicator self(MPI_COMM_SELF);
    const auto result = run_sample(
        self, parameters, parameters.output,
        cracked(parameters, {.size = parameters.specimen.size, .cells = {4, 4, 8}, .disturbance = 0.2}));
    double kinetic = 0;
    for (const EnergyRow& row : result.energy) kinetic = std::max(kinetic, row.kinetic);
    const EnergyRow &first = result.energy.front(), &last = result.energy.back();
    std::printf(
        "friction %.1f: kinetic energy up to %.1e of the strain energy, which changes by %.1e; energy error "
        "%.1e, friction %.2e of the work\n",
        friction, kinetic / first.strain, last.strain / first.strain - 1, result.energy_error,
        last.dissipated / last.external);
    EXPECT_LT(kinetic, 1e-6 * first.strain);
    EXPECT_NEAR(last.strain / first.strain, 1, 1e-5);
    EXPECT_LT(result.energy_error, 1e-3);
    EXPECT_EQ(last.dissipated > 1e-3 * last.external, friction > 0);
  }
}

/// When a plane wave of compression, from a face that is pushed, gets past the middle of a bar.
double front(bool is_cut) {
  constexpr double rise = 1e-6;
  auto parameters = test::brittle({1.5 * mm, 1.5 * mm, 20 * mm});
  parameters.fracture.strength = 1e12;
  parameters.mesh.spacing = parameters.mesh.notch_spacing = 0.5 * mm;
  parameters.mesh.perturbation = 0.2;
  if (is_cut) parameters.specimen.cracks = {crack_along({-1 * mm, 10 * mm}, {3 * mm, 10 * mm})};
  if (is_cut) parameters.fracture.contact = input::Contact::frictionless;
  for (const auto face : {Face::x_min, Face::x_max, Face::y_min, Face::y_max}) {
    const bool is_x = face == Face::x_min || face == Face::x_max;
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {is_x, !is_x, false}));
  }
  parameters.boundaries.push_back(
      test::boundary(Face::z_min, BoundaryKind::velocity, {false, false, true}, {0, 0, 1}));
  parameters.boundaries.back().history = {{0, 0}, {rise, 1}};
  parameters.time.start = input::Start::rest;
  parameters.time.integrator = input::Integrator::verlet;
  parameters.time.precision = input::Precision::double_;
  parameters.time.duration = 10.5e-6;
  parameters.output.history = 5e-8;
  for (const double across : {0.4 * mm, 0.75 * mm, 1.1 * mm})
    parameters.output.probes.push_back({"", {across, across, 17.5 * mm}});
  auto mesh = test::realization(parameters);
  geometry::open_pre_cracks(parameters.specimen.cracks, {{}, parameters.specimen.size}, mesh);
  const auto result =
      run_sample(parallel::Communicator(MPI_COMM_SELF), parameters, parameters.output, test::whole(mesh));
  double last = 0, before = 0;
  for (const HistoryRow& row : result.history) {
    double now = 0;
    for (const ProbeValue& probe : row.probes) now += probe.velocity[2] / 3;
    if (now > 0.5) return std::lerp(before, row.load_time, (0.5 - last) / (now - last));
    last = now, before = row.load_time;
  }
  return infinity;
}

TEST(ClosedCrack, FromTheStartLetsCompressionPass) {
  const double whole = front(false), with = front(true);
  std::printf("compression through a crack from the start: front at %.3f us (uncracked %.3f us)\n",
              1e6 * with, 1e6 * whole);
  EXPECT_NEAR(with / whole, 1, 0.017);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
