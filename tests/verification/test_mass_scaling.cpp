// SPDX-License-Identifier: GPL-3.0-or-later
// Mass added for a longer step: it keeps its limits, delays waves by half its share, and leaves the weight.
#include "dynamics/mass_scaling.h"
#include "dynamics/sample_run.h"
#include "dynamics/sample_setup.h"

#include "support/effort.h"
#include "support/elastic_motion.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

/// A bar of irregular mesh, free at its ends, between walls that let plane waves pass along them.
input::Parameters bar(int axis) {
  input::Parameters parameters = test::brittle({0.002, 0.002, 0.012});
  for (const Face face : {Face::y_min, Face::y_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {false, true, false}));
  for (const Face face : {Face::x_min, Face::x_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {axis == 2, false, axis == 0}));
  return parameters;
}

/// The frequency of the standing wave cos(pi z / L), relative to the exact one, less 1.
struct Frequency {
  double error;     ///< of the motion after two and a quarter periods, at which the exact wave is 0
  double expected;  ///< by Rayleigh's quotient with the masses, of a mesh that resolves the wave
  std::optional<MassScaling> scaling;
};

Frequency frequency_of(const geometry::Realization& mesh, const input::Parameters& parameters, int axis) {
  test::ElasticMotion motion(mesh, parameters);
  const mechanics::IsotropicElasticity elasticity(parameters.material());
  const double density = parameters.material().density, length = parameters.specimen.size[2];
  const double modulus = axis == 2 ? elasticity.lambda + 2 * elasticity.mu : elasticity.mu;
  const double duration = 2.25 * 2 * length / std::sqrt(modulus / density), amplitude = 1e-6;
  const auto component = static_cast<std::size_t>(axis);
  const auto shape = [&](std::size_t n) {
    return std::cos(std::numbers::pi * motion.subdomain().nodes[n][2] / length);
  };
  for (std::size_t n = 0; n < motion.n_nodes(); ++n)
    motion.state().displacement.local()[3 * n + component] = amplitude * shape(n);
  motion.start(duration);
  const auto n_steps = static_cast<std::int64_t>(std::ceil(duration / (0.5 * motion.stable_step())));
  motion.advance(n_steps, duration / static_cast<double>(n_steps));
  double projection = 0, norm = 0, true_norm = 0;
  for (std::size_t n = 0; n < motion.n_nodes(); ++n) {
    projection += motion.mass(n) * motion.displacement(n, component) * shape(n);
    norm += motion.mass(n) * shape(n) * shape(n);
    true_norm += density * motion.body().operators().node_volume[n] * shape(n) * shape(n);
  }
  return {std::asin(-projection / (amplitude * norm)) / (2 * std::numbers::pi * 2.25),
          std::sqrt(true_norm / norm) - 1, motion.mass_scaling()};
}

TEST(MassScaling, DelaysPlaneWavesByHalfTheShareOfMass) {
  for (const int axis : {2, 0}) {
    auto parameters = bar(axis);
    const auto mesh = test::irregular_box(parameters.specimen.size, 0.35e-3);
    const Frequency before = frequency_of(mesh, parameters, axis);
    EXPECT_LT(std::abs(before.error), 1e-3);
    EXPECT_FALSE(before.scaling);
    for (const double share :
         test::is_full() ? std::vector{0.001, 0.002, 0.005, 0.02} : std::vector{0.002, 0.02}) {
      parameters.time.mass_scaling = share;
      const auto [error, expected, scaling] = frequency_of(mesh, parameters, axis);
      ASSERT_TRUE(scaling);
      std::printf(
          "%s wave, %.2f %% of mass added at %.1f %% of the nodes, step %.2f times as long: speed %+.3f %% "
          "off "
          "the exact one, %+.3f %% without; difference %+.4f %%, expected %+.4f %%\n",
          axis == 2 ? "P" : "S", 100 * scaling->share, 100 * scaling->node_share, scaling->gain, 100 * error,
          100 * before.error, 100 * (error - before.error), 100 * expected);
      EXPECT_NEAR(scaling->share, share, 1e-6);
      EXPECT_NEAR((error - before.error) / expected, 1, 0.05);
      EXPECT_NEAR(expected, -share / 2, 0.15 * share);
      EXPECT_GT(scaling->gain, share < 0.01 ? 1.05 : 1.15);
    }
  }
}

/// A bar with a finer part.
geometry::Realization graded_bar() {
  auto parameters = test::brittle({0.002, 0.002, 0.012});
  parameters.seed = 1;
  parameters.mesh.spacing = parameters.mesh.notch_spacing = 0.8e-3;
  parameters.mesh.growth = parameters.mesh.perturbation = parameters.mesh.min_quality = 0.2;
  auto& region = parameters.mesh.regions.emplace_back();
  region.spacing = 0.3e-3;
  region.box[2] = {0.005, 0.006};
  return test::realization(parameters);
}

TEST(MassScaling, KeepsItsShareInTheBodyAndWhereItIsFine) {
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto mesh = graded_bar();
  const auto subdomain = test::whole(mesh);
  auto parameters = test::brittle({0.002, 0.002, 0.012});
  const double share = parameters.time.mass_scaling = 0.002;
  fracture::BreakableBody body(subdomain, parameters.material());
  const std::vector<double> mass = body.operators().node_mass;
  const auto before = frequency_bounds(subdomain, body.operators(), body.elasticity());
  const double square = std::pow(largest_frequency(self, subdomain, body.operators(), body.force()), 2);
  EXPECT_GE(std::ranges::max(before), square) << "a bound";
  const auto scaling =
      scale_masses(self, parameters, subdomain, body.operators(), body.material(), body.force());
  ASSERT_TRUE(scaling);
  const auto after = frequency_bounds(subdomain, body.operators(), body.elasticity());
  const double bound = std::ranges::max(after);
  double whole = 0, added = 0, n_scaled = 0;
  for (std::size_t n = 0; n < mass.size(); ++n) {
    const double more = body.operators().node_mass[n] - mass[n];
    EXPECT_GE(more, 0);
    EXPECT_TRUE(more == 0 || std::abs(after[n] / bound - 1) < 1e-12) << "no more than is needed";
    whole += mass[n];
    added += more;
    n_scaled += more > 0 ? 1 : 0;
  }
  const double square_after = std::pow(largest_frequency(self, subdomain, body.operators(), body.force()), 2);
  std::printf("%s; the largest frequency is %.3f, then %.3f times its bound\n", to_string(*scaling).c_str(),
              std::sqrt(square / std::ranges::max(before)), std::sqrt(square_after / bound));
  EXPECT_NEAR(scaling->share, added / whole, 1e-9);
  EXPECT_NEAR(scaling->corridor_share, share, 1e-6) << "where it is fine decides";
  EXPECT_LT(scaling->share, 0.7 * share);
  EXPECT_EQ(scaling->node_share, n_scaled / static_cast<double>(mass.size()));
  EXPECT_NEAR(scaling->gain, std::sqrt(square / square_after), 1e-6);
  EXPECT_GT(scaling->gain, 1.05);
}

/// Weight is that of the body's own mass; the kinetic energy, that of all mass, closes the balance.
TEST(MassScaling, AddsNoWeightAndKeepsTheEnergy) {
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto mesh = graded_bar();
  const auto subdomain = test::whole(mesh);
  auto parameters = test::brittle({0.002, 0.002, 0.012});
  parameters.fracture.strength = 1e12;
  parameters.time.start = input::Start::rest;
  parameters.time.mass_scaling = 0.01;
  input::BodyLoad gravity;
  gravity.value = {0, 0, 1e4};
  parameters.loads = {gravity};
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true})};
  const double weight = 1e4 * parameters.material().density * 0.002 * 0.002 * 0.012;
  for (const auto integrator : {input::Integrator::bilateral4, input::Integrator::verlet}) {
    for (const auto engine : {input::Engine::fixed_point, input::Engine::petsc}) {
      parameters.time.integrator = integrator;
      parameters.time.engine = engine;
      parameters.time.precision = input::Precision::double_;
      const SampleSetup setup(self, parameters, subdomain, 0);
      ASSERT_EQ(setup.loads.forces.size(), 1U);
      EXPECT_NEAR(setup.loads.forces[0].amplitude.at(0) * setup.loads.forces[0].resultant / weight, 1, 1e-12);
      const SampleResult result = run_sample(self, parameters, parameters.output, subdomain);
      std::printf("energy error %.1e, %.3g J of %.3g J kinetic\n", result.energy_error,
                  result.energy.back().kinetic, result.energy.back().external);
      EXPECT_LT(result.energy_error, integrator == input::Integrator::verlet ? 1e-4 : 1e-7);
      EXPECT_GT(result.energy.back().kinetic, 0);
      EXPECT_EQ(result.mass_scaling, setup.mass_scaling);
    }
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
