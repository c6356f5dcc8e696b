// SPDX-License-Identifier: GPL-3.0-or-later
// Time integration against the exact motion of a small elastic body, known from its eigenmodes, and against
// waves.
#include "common/index.h"
#include "dynamics/explicit_phase.h"
#include "dynamics/sample_run.h"
#include "dynamics/stable_step.h"

#include "support/box_mesh.h"
#include "support/effort.h"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using input::Integrator;
using plane::Face;

input::Fracture unbreakable() {
  return {.strength = 1e15, .exponent = 2, .impulse = 1e4};
}

/// A small elastic block and its exact free motion u(t) = M^-1/2 Q cos(Omega t) Q^T M^1/2 u(0).
class SmallBody {
public:
  SmallBody()
      : mesh_(test::make_box({.size = {0.004, 0.005, 0.006}, .cells = {2, 2, 3}, .disturbance = 0.15})),
        subdomain_(test::whole(mesh_)),
        body_(subdomain_, test::epoxy()) {
    const auto n = static_cast<Eigen::Index>(3 * subdomain_.nodes.size());
    Eigen::MatrixXd stiffness(n, n);
    std::vector<double> u(static_cast<std::size_t>(n)), f(static_cast<std::size_t>(n));
    for (Eigen::Index column = 0; column < n; ++column) {
      std::ranges::fill(u, 0.0);
      u[index(column)] = 1;
      body_.force().evaluate(u, f);
      stiffness.col(column) = Eigen::Map<Eigen::VectorXd>(f.data(), n);
    }
    root_mass_.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      root_mass_[i] = std::sqrt(body_.operators().node_mass[index(i) / 3]);
    }
    const Eigen::VectorXd inverse = root_mass_.cwiseInverse();
    const Eigen::MatrixXd scaled =
        inverse.asDiagonal() * (0.5 * (stiffness + stiffness.transpose())) * inverse.asDiagonal();
    modes_.compute(scaled);
  }

  double largest_frequency() const {
    return std::sqrt(modes_.eigenvalues()[modes_.eigenvalues().size() - 1]);
  }

  Eigen::VectorXd exact(const Eigen::VectorXd& start, double time) const {
    Eigen::VectorXd amplitude = modes_.eigenvectors().transpose() * root_mass_.cwiseProduct(start);
    for (Eigen::Index i = 0; i < amplitude.size(); ++i) {
      amplitude[i] *= std::cos(std::sqrt(std::max(0.0, modes_.eigenvalues()[i])) * time);
    }
    return (modes_.eigenvectors() * amplitude).cwiseQuotient(root_mass_);
  }

  Eigen::VectorXd smooth_start() const {
    Eigen::VectorXd u(3 * static_cast<Eigen::Index>(subdomain_.nodes.size()));
    for (std::size_t i = 0; i < subdomain_.nodes.size(); ++i) {
      const auto& p = subdomain_.nodes[i];
      const auto at = static_cast<Eigen::Index>(3 * i);
      u[at] = 1e-6 * std::cos(std::numbers::pi * p[2] / 0.006);
      u[at + 1] = 2e-6 * std::sin(std::numbers::pi * p[0] / 0.004);
      u[at + 2] = 1e-6 * std::cos(std::numbers::pi * p[1] / 0.005);
    }
    return u;
  }

  /// Integrates from rest at `start`; returns the final state and the phase.
  std::pair<MotionState, PhaseResult> integrate(const Eigen::VectorXd& start, Integrator integrator,
                                                double dt, std::int64_t n_steps,
                                                double initial_velocity = 0) {
    const mechanics::Conditions no_loads;
    auto law = test::tuler_butcher(unbreakable(), subdomain_);
    const EnergyAccount account(self_, body_);
    MotionState state{parallel::NodeField(self_, subdomain_.layout),
                      parallel::NodeField(self_, subdomain_.layout)};
    for (std::size_t i = 0; i < state.displacement.local().size(); ++i) {
      state.displacement.local()[i] = start[static_cast<Eigen::Index>(i)];
      state.velocity.local()[i] = initial_velocity * static_cast<double>(i % 3);
    }
    PhaseOptions options;
    options.grid = {dt, n_steps};
    const MotionContext context{&self_, &body_, &no_loads, &law};
    const auto motion = make_reference_motion(context, 0, state);
    auto result = run_explicit_phase(context, *motion, splitting(integrator), account, 0, options, state);
    return {std::move(state), std::move(result)};
  }

  const fracture::BreakableBody& body() const { return body_; }
  const geometry::Subdomain& subdomain() const { return subdomain_; }
  const geometry::Realization& mesh() const { return mesh_; }
  const parallel::Communicator& self() const { return self_; }

private:
  parallel::Communicator self_{MPI_COMM_SELF};
  geometry::Realization mesh_;
  geometry::Subdomain subdomain_;
  fracture::BreakableBody body_;
  Eigen::VectorXd root_mass_;
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes_;
};

class Order : public ::testing::TestWithParam<std::pair<Integrator, double>> {};

TEST_P(Order, OfConvergenceIsThatOfTheIntegrator) {
  const auto [integrator, expected] = GetParam();
  SmallBody body;
  const Eigen::VectorXd start = body.smooth_start();
  const double duration = 2e-5;
  const Eigen::VectorXd exact = body.exact(start, duration);
  std::vector<double> errors;
  for (std::int64_t n_steps = 128; n_steps <= 512; n_steps *= 2) {
    const auto [state, phase] =
        body.integrate(start, integrator, duration / static_cast<double>(n_steps), n_steps);
    const Eigen::Map<const Eigen::VectorXd> u(state.displacement.local().data(), exact.size());
    errors.push_back((u - exact).norm() / exact.norm());
    std::printf("%s: %lld steps, relative error %.3e",
                integrator == Integrator::verlet ? "verlet" : "bilateral4", static_cast<long long>(n_steps),
                errors.back());
    if (errors.size() > 1) {
      const double order = std::log2(errors[errors.size() - 2] / errors.back());
      std::printf(", order %.3f", order);
      EXPECT_NEAR(order, expected, 0.1);
    }
    std::printf("\n");
  }
}

INSTANTIATE_TEST_SUITE_P(Integrators, Order,
                         ::testing::Values(std::pair{Integrator::verlet, 2.0},
                                           std::pair{Integrator::bilateral4, 4.0}));

TEST(Dynamics, LargestFrequencyIsThatOfTheEigenmodes) {
  SmallBody body;
  const double lanczos =
      largest_frequency(body.self(), body.subdomain(), body.body().operators(), body.body().force());
  std::printf("omega_max: Lanczos %.6e, eigenmodes %.6e 1/s\n", lanczos, body.largest_frequency());
  EXPECT_GE(lanczos, body.largest_frequency() * (1 - 1e-12));
  EXPECT_LT(lanczos, 1.001 * body.largest_frequency());
}

TEST(Dynamics, EnergyStaysBoundedAndMomentumKeptOverManySteps) {
  SmallBody body;
  for (const auto integrator : {Integrator::verlet, Integrator::bilateral4}) {
    const double dt = 0.5 * splitting(integrator).stability_limit / body.largest_frequency();
    const std::int64_t n_steps = test::repetitions(20000, 100000);
    const auto [state, phase] = body.integrate(body.smooth_start(), integrator, dt, n_steps, 1e-3);
    const auto total = [](const EnergyRow& row) { return row.kinetic + row.strain; };
    double early = 0, late = 0;
    for (std::size_t i = 0; i < phase.energy.size(); ++i) {
      const double change = std::abs(total(phase.energy[i]) / total(phase.energy[0]) - 1);
      (i < phase.energy.size() / 2 ? early : late) =
          std::max(i < phase.energy.size() / 2 ? early : late, change);
    }
    double momentum[3] = {0, 0, 0}, scale = 0, mass = 0;
    for (std::size_t n = 0; n < body.subdomain().nodes.size(); ++n) {
      const double m = body.body().operators().node_mass[n];
      mass += m;
      for (std::size_t i = 0; i < 3; ++i) {
        momentum[i] += m * state.velocity.local()[3 * n + i];
        scale += m * std::abs(state.velocity.local()[3 * n + i]);
      }
    }
    std::printf(
        "%s, omega dt %.2f, %lld steps: energy change %.2e (first half), %.2e (second half), momentum error "
        "%.2e\n",
        integrator == Integrator::verlet ? "verlet" : "bilateral4", dt * body.largest_frequency(),
        static_cast<long long>(n_steps), early, late, std::abs(momentum[2] - mass * 2e-3) / scale);
    EXPECT_LT(early, integrator == Integrator::verlet ? 0.1 : 0.01);
    EXPECT_LT(late, 1.2 * early) << "the energy error must not grow";
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(momentum[i], mass * 1e-3 * static_cast<double>(i), 1e-10 * scale);
  }
}

TEST(Dynamics, StepAboveTheStableOneIsRefusedWithItsValue) {
  input::Time time;
  time.duration = 1e-4;
  time.step = 2e-8;
  EXPECT_NO_THROW(choose_time_grid(time, 2.1e-8));
  try {
    choose_time_grid(time, 1.9e-8);
    FAIL() << "the step was accepted";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("19 ns"), std::string::npos) << error.what();
  }
}

TEST(Dynamics, TimeGridCoversTheDurationInWholeCycles) {
  input::Time time;
  time.duration = 1e-4;
  time.step = 5e-9;
  EXPECT_EQ(choose_time_grid(time, 1e-8).n_steps, 20000);
  time.step = 3e-5;
  EXPECT_EQ(choose_time_grid(time, 1).n_steps, 4);  // 3.33 steps, whole pairs
  time.step.reset();
  const auto grid = choose_time_grid(time, 1e-8);
  EXPECT_LE(grid.step, 0.9e-8);
  EXPECT_NEAR(grid.step * static_cast<double>(grid.n_steps), time.duration, 1e-18);
  EXPECT_EQ(grid.n_steps % 2, 0);
}

TEST(Dynamics, WaveInASlenderBarArrivesWithTheBarSpeed) {
  // A bar 2 mm x 2 mm x 200 mm, suddenly pulled at its end: half of the velocity behind the front is reached
  // in the middle after 100 mm / sqrt(E/rho).
  const double length = 0.2, width = 0.002, stress = 1e6;
  const auto mesh = test::make_box({.size = {width, width, length}, .cells = {2, 2, 200}});
  const auto subdomain = test::whole(mesh);
  input::Parameters parameters;
  parameters.specimen.size = {width, width, length};
  parameters.materials[0] = test::epoxy();
  parameters.fracture = unbreakable();
  parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}));
  parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::traction, {}, {0, 0, stress}));
  parameters.time.start = input::Start::rest;
  parameters.time.duration = 8e-5;
  parameters.time.integrator = Integrator::verlet;
  parameters.output.frames = 401;
  const parallel::Communicator self(MPI_COMM_SELF);
  const SampleResult result = run_sample(self, parameters, parameters.output, subdomain);

  const double c = std::sqrt(parameters.materials[0].youngs_modulus / parameters.materials[0].density);
  const double plateau = stress / (parameters.materials[0].density * c);
  double arrival = 0;
  for (const auto& frame : result.frames) {
    double velocity = 0;
    int n = 0;
    for (std::size_t node = 0; node < subdomain.nodes.size(); ++node) {
      if (std::abs(subdomain.nodes[node][2] - length / 2) > 1e-9) continue;
      velocity += static_cast<double>(frame.velocity[3 * node + 2]);
      ++n;
    }
    if (velocity / n >= plateau / 2) {
      arrival = frame.time;
      break;
    }
  }
  std::printf("arrival at the middle: %.3f us, exact %.3f us; energy error %.2e\n", arrival * 1e6,
              0.5 * length / c * 1e6, result.energy_error);
  EXPECT_NEAR(arrival, 0.5 * length / c, 0.01 * 0.5 * length / c);
  EXPECT_LT(result.energy_error, 1e-2);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
