// SPDX-License-Identifier: GPL-3.0-or-later
// Stress from the start beside exact solutions: tempered plates, cooled bars, and a quench that breaks a bar.
#include "common/index.h"
#include "dynamics/quasi_static.h"
#include "dynamics/sample_run.h"
#include "fracture/initial_strain.h"
#include "fracture/material_field.h"
#include "mechanics/conditions.h"

#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using input::InitialStressKind;
using mechanics::Symmetric;
using plane::Face;

/// A block in equilibrium under its initial stress.
class Block {
public:
  Block(const input::Parameters& parameters, const geometry::Realization& mesh, bool is_free = false)
      : subdomain_(test::whole(mesh)),
        body_(subdomain_, parameters.material()),
        loads_(is_free ? three_points(parameters.specimen.size)
                       : mechanics::make_boundary_loads(self_, parameters, subdomain_)),
        law_(test::unbreakable(subdomain_)) {
    body_.set_initial_strain(
        fracture::make_initial_strain(parameters, body_.elasticity(), fracture::span_of(subdomain_)));
    const QuasiStaticLoading loading(self_, body_, loads_, law_, 1);
    const auto u = loading.displacement().local();
    for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); ++t) stress.push_back(body_.stress(t, u));
    energy = strain_energy(self_, body_, u);
    // The internal force of an equilibrium vanishes where no condition holds the body.
    std::vector<double> force(u.size());
    body_.force().evaluate(u, force);
    for (const auto& motion : loads_.motions)
      for (const auto node : motion.nodes) force[index(node, motion.component)] = 0;
    for (const double f : force) residual = std::max(residual, std::abs(f));
  }

  geometry::Point centroid(std::size_t t) const {
    geometry::Point mean{};
    for (const auto node : subdomain_.tetrahedra[t]) mean = mean + 0.25 * subdomain_.nodes[index(node)];
    return mean;
  }

  std::vector<Symmetric> stress;  ///< of each tetrahedron [Pa]
  double energy = 0;              ///< [J]
  double residual = 0;            ///< largest force at a free node [N]

private:
  /// Holds the body at three corners, without any force.
  mechanics::Conditions three_points(const geometry::Point& size) const {
    const auto at = [&](const geometry::Point& p) {
      for (std::int32_t n = 0;; ++n)
        if (norm(subdomain_.nodes[index(n)] - p) < 1e-9) return n;
    };
    const std::int32_t a = at({0, 0, 0}), b = at({0, size[1], 0}), c = at({0, 0, size[2]});
    mechanics::Conditions loads;
    loads.motions = {{.component = 0, .is_fixed = true, .curve = {}, .nodes = {a, b, c}},
                     {.component = 1, .is_fixed = true, .curve = {}, .nodes = {a, c}},
                     {.component = 2, .is_fixed = true, .curve = {}, .nodes = {a}}};
    return loads;
  }

  parallel::Communicator self_{MPI_COMM_SELF};
  geometry::Subdomain subdomain_;
  fracture::BreakableBody body_;
  mechanics::Conditions loads_;
  fracture::FractureLaw law_;
};

const geometry::Point plate_size{0.008, 0.044, 0.044};

input::Parameters tempered_plate() {
  input::Parameters parameters;
  parameters.specimen.size = plate_size;
  parameters.materials[0] = {70e9, 0.23, 2500};
  auto& stress = parameters.initial_stresses.emplace_back();
  stress.along = 0;
  stress.kind = InitialStressKind::surface;
  stress.surface = -100e6;
  return parameters;
}

geometry::Realization plate_mesh(int cells, double disturbance) {
  return test::make_box({.size = plate_size, .cells = {cells, 20, 20}, .disturbance = disturbance});
}

TEST(TemperedPlate, HasTheEnergyOfItsParabolaBetweenRollers) {
  auto parameters = tempered_plate();
  for (const auto face : {Face::y_min, Face::y_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {false, true, false}));
  for (const auto face : {Face::z_min, Face::z_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {false, false, true}));
  auto line = test::boundary(Face::x_min, BoundaryKind::fix, {true, false, false});
  line.region[1] = {0, 0};
  parameters.boundaries.push_back(line);
  // The integral of (1 - 6 s (1 - s))^2 is 1/5.
  const double volume = plate_size[0] * plate_size[1] * plate_size[2];
  const double exact = volume * 1e16 * (1 - 0.23) / (5 * 70e9);
  double last = 1;
  for (const int cells : {4, 8, 16}) {
    const Block plate(parameters, plate_mesh(cells, 0));
    const double error = plate.energy / exact - 1;
    std::printf("%d cells: %.6g J, off the closed form by %.2f %%\n", cells, plate.energy, 100 * error);
    EXPECT_LT(std::abs(error), std::abs(last) / 3);
    last = error;
  }
  EXPECT_LT(std::abs(last), 0.01);
}

TEST(TemperedPlate, KeepsItsProfileAwayFromItsEdges) {
  auto parameters = tempered_plate();
  for (const double disturbance : {0.0, 0.2}) {
    const Block plate(parameters, plate_mesh(8, disturbance), true);
    const std::size_t n_layers = 8;
    std::vector<double> sum(n_layers), n(n_layers);
    double worst = 0, squares = 0, count = 0;
    for (std::size_t t = 0; t < plate.stress.size(); ++t) {
      const auto p = plate.centroid(t);
      const double edge = std::min({p[1], p[2], plate_size[1] - p[1], plate_size[2] - p[2]}) / plate_size[0];
      if (edge < 1.5) continue;
      const double s = p[0] / plate_size[0];
      const double expected = -100e6 * (1 - 6 * s * (1 - s));
      const auto layer = static_cast<std::size_t>(s * static_cast<double>(n_layers));
      for (const std::size_t c : {1U, 2U}) {
        const double off = (plate.stress[t][c] - expected) / 100e6;
        sum[layer] += off;
        n[layer] += 1;
        worst = std::max(worst, std::abs(off));
        squares += off * off;
        count += 1;
      }
    }
    double of_layers = 0;
    for (std::size_t i = 0; i < n_layers; ++i) of_layers = std::max(of_layers, std::abs(sum[i] / n[i]));
    std::printf(
        "disturbance %.1f: mean of a layer off by up to %.2f %% of the surface stress, tetrahedra by %.2f %% "
        "rms, %.2f %% at most; residual %.1e N\n",
        disturbance, 100 * of_layers, 100 * std::sqrt(squares / count), 100 * worst, plate.residual);
    EXPECT_LT(of_layers, 0.01);
    EXPECT_LT(plate.residual, 1e-6 * 100e6 * std::pow(plate_size[0] / 8, 2));
  }
}

/// A bar that cools by 100 K, with its temperature between the ends as given.
input::Parameters cooled_bar(double at_lower_end, double at_upper_end) {
  input::Parameters parameters;
  parameters.specimen.size = {0.004, 0.004, 0.012};
  parameters.materials[0] = {70e9, 0.23, 2500};
  auto& stress = parameters.initial_stresses.emplace_back();
  stress.along = 2;
  stress.kind = InitialStressKind::temperature;
  stress.expansion = 9e-6;
  stress.temperature = {{0, at_lower_end}, {0.012, at_upper_end}};
  return parameters;
}

geometry::Realization bar_mesh(int refinement = 1) {
  return test::make_box({.size = {0.004, 0.004, 0.012},
                         .cells = {4 * refinement, 4 * refinement, 12 * refinement},
                         .disturbance = 0.2});
}

double largest_stress(const Block& block) {
  double largest = 0;
  for (const Symmetric& sigma : block.stress)
    for (const double component : sigma) largest = std::max(largest, std::abs(component));
  return largest;
}

TEST(CooledBar, BetweenRigidWallsHasTheExactStress) {
  const double full = 70e9 * 9e-6 * 100;
  auto parameters = cooled_bar(-100, -100);
  for (const auto face : {Face::z_min, Face::z_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {false, false, true}));
  auto walled = parameters;
  for (const auto face : {Face::x_min, Face::x_max, Face::y_min, Face::y_max}) {
    const bool is_x = face == Face::x_min || face == Face::x_max;
    walled.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {is_x, !is_x, false}));
    if (is_x && face == Face::x_max) continue;
    if (!is_x && face == Face::y_max) continue;
    parameters.boundaries.push_back(walled.boundaries.back());
  }
  double worst = 0, worst_walled = 0;
  for (const Symmetric& sigma : Block(parameters, bar_mesh()).stress)
    worst = std::max({worst, std::abs(sigma[2] / full - 1), std::abs(sigma[0]) / full});
  const double confined = full / (1 - 2 * 0.23);
  for (const Symmetric& sigma : Block(walled, bar_mesh()).stress)
    for (const std::size_t c : {0U, 1U, 2U})
      worst_walled = std::max(worst_walled, std::abs(sigma[c] / confined - 1));
  std::printf("between its ends %.1e off, between walls on all sides %.1e\n", worst, worst_walled);
  EXPECT_LT(worst, 2e-7);
  EXPECT_LT(worst_walled, 1e-12);
}

TEST(CooledBar, LeftFreeHasNoStress) {
  const double full = 70e9 * 9e-6 * 100;
  const double uniform = largest_stress(Block(cooled_bar(-100, -100), bar_mesh(), true)) / full;
  // Displacements are then quadratic, which linear tetrahedra approach.
  const double coarse = largest_stress(Block(cooled_bar(0, -100), bar_mesh(), true)) / full;
  const double fine = largest_stress(Block(cooled_bar(0, -100), bar_mesh(2), true)) / full;
  std::printf("cooled evenly %.1e of E alpha dT, along its length %.3f, on half the spacing %.3f\n", uniform,
              coarse, fine);
  EXPECT_LT(uniform, 2e-7);
  EXPECT_LT(coarse, 0.1);
  EXPECT_LT(fine, 0.65 * coarse);
}

TEST(CooledBar, OfTwoMaterialsMayShrinkInOneOnly) {
  auto parameters = cooled_bar(-100, -100);
  parameters.materials[0].name = "substrate";
  parameters.materials.push_back(parameters.materials[0]);
  parameters.materials[1].name = "film";
  parameters.initial_stresses[0].material = "film";
  const auto subdomain = test::whole(bar_mesh());
  std::vector<std::uint8_t> material;
  for (std::size_t t = 0; t < subdomain.tetrahedra.size(); ++t)
    material.push_back(static_cast<std::uint8_t>(t % 3 == 0 ? 1 : 0));
  fracture::TetrahedronSpan tetrahedra = fracture::span_of(subdomain);
  tetrahedra.material = material;
  const auto strain = fracture::initial_strain_at(
      parameters, 0, fracture::make_material_field(parameters, 0, tetrahedra).elasticity, tetrahedra);
  for (std::size_t t = 0; t < strain.size(); ++t) EXPECT_DOUBLE_EQ(strain[t][1], t % 3 == 0 ? -9e-4 : 0) << t;
}

/// Held at both ends.
input::Parameters quenched_bar() {
  auto parameters = cooled_bar(-100, -100);
  parameters.fracture = {.strength = 35e6, .exponent = 2, .impulse = 1e4};
  parameters.time.duration = 2e-5;
  parameters.time.arrest = 1e-30;
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}),
                           test::boundary(Face::z_max, BoundaryKind::fix, {true, true, true})};
  return parameters;
}

TEST(Quench, BreaksTheBarAtTheExactTimeAndClosesTheEnergyAccount) {
  auto parameters = quenched_bar();
  // Rollers at the ends, and the change of temperature as a sum of hats: -20 K at 1 s, -100 K at 3 s.
  parameters.boundaries[0] = test::boundary(Face::z_min, BoundaryKind::fix, {false, false, true});
  parameters.boundaries[1] = test::boundary(Face::z_max, BoundaryKind::fix, {false, false, true});
  parameters.boundaries.push_back(test::boundary(Face::x_min, BoundaryKind::fix, {true, false, false}));
  parameters.boundaries.push_back(test::boundary(Face::y_min, BoundaryKind::fix, {false, true, false}));
  auto first = parameters.initial_stresses[0], last = first;
  first.temperature = {{0, -20}};
  first.history = {{0, 0}, {1, 1}, {3, 0}};
  last.history = {{1, 0}, {3, 1}};
  parameters.initial_stresses = {first, last};
  for (const auto release : {input::Release::element, input::Release::facet}) {
    parameters.fracture.release = release;
    const parallel::Communicator self(MPI_COMM_SELF);
    const auto result = run_sample(self, parameters, parameters.output, test::whole(bar_mesh()));
    ASSERT_FALSE(result.breaks.empty());
    const double at_break = 35e6 / (70e9 * 9e-6);  // [K]
    const double expected = 1 + 2 * (at_break - 20) / 80;
    std::printf(
        "first break at %.12g s, expected %.12g s; %s after %zu breaks and %lld solves, energy error %.1e\n",
        result.breaks.front().load_time, expected, to_string(result.outcome).c_str(), result.breaks.size(),
        static_cast<long long>(result.counts.static_solves), result.energy_error);
    EXPECT_NEAR(result.breaks.front().load_time, expected, 1e-7 * expected);
    EXPECT_LT(result.energy_error, 1e-7);
    double released = 0;
    for (const auto& record : result.breaks) released += record.released_energy;
    EXPECT_GT(released, 0);
  }
}

TEST(Quench, GoesOnAfterADynamicPhaseWithTheEnergyAccountClosed) {
  auto parameters = quenched_bar();
  parameters.time.arrest = 2e-6;
  parameters.time.precision = input::Precision::double_;
  // Cold at one surface only, so that cracks arrest.
  parameters.initial_stresses[0].along = 0;
  parameters.initial_stresses[0].temperature = {{0, -100}, {0.0015, 0}};
  parameters.initial_stresses[0].history = {{0, 0}, {1, 1}, {4, 2}};
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto result = run_sample(self, parameters, parameters.output, test::whole(bar_mesh()));
  std::printf("%s after %zu breaks in %lld dynamic phases, energy error %.1e\n",
              to_string(result.outcome).c_str(), result.breaks.size(),
              static_cast<long long>(result.counts.dynamic_phases), result.energy_error);
  EXPECT_GE(result.counts.dynamic_phases, 2);
  EXPECT_GT(result.breaks.size(), 10U);
  EXPECT_LT(result.energy_error, 1e-4);
  for (const double load : {result.first_break_load, result.onset_force, result.loads.peak_load})
    EXPECT_TRUE(std::isnan(load)) << "there is no machine";
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
