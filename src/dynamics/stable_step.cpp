// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/stable_step.h"

#include "common/failure.h"
#include "common/index.h"
#include "common/random.h"
#include "dynamics/integrator.h"
#include "fracture/material_field.h"
#include "geometry/partition.h"
#include "parallel/agreement.h"
#include "parallel/exact_sum.h"
#include "parallel/ghost_exchange.h"

#include "contact_stiffness.h"
#include "viscous_force.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

namespace crackle::dynamics {

namespace {

constexpr int max_lanczos_steps = 60;
constexpr double lanczos_tolerance = 1e-3;  // relative to the squared frequency
constexpr double fraction_of_stable_step = 0.9;

using Exchange = parallel::GhostExchange<std::array<double, 3>>;

/// @param values three of each local node, the ghosts last
void update_ghosts(Exchange& exchange, std::span<double> values) {
  for (std::size_t i = 0; i < exchange.sent().size(); ++i)
    std::ranges::copy(values.subspan(3 * index(exchange.sent_nodes()[i]), 3), exchange.sent()[i].begin());
  exchange.begin();
  exchange.end();
  const auto ghosts = values.last(3 * exchange.received().size());
  for (std::size_t i = 0; i < ghosts.size(); ++i) ghosts[i] = exchange.received()[i / 3][i % 3];
}

/// @param force linear in the displacement; both 3 n_local
template <class Force>
double largest_frequency_of(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                            const mechanics::PdsOperators& operators, const Force& force) {
  const auto n = 3 * static_cast<std::size_t>(subdomain.layout.n_owned);
  std::vector<double> scale(n);  // M^-1/2
  for (std::size_t i = 0; i < n; ++i) scale[i] = 1 / std::sqrt(operators.node_mass[i / 3]);

  std::vector<double> current(n), previous(n, 0.0), next(n);
  const RandomStream stream(0, 0, "lanczos");
  for (std::size_t i = 0; i < n; ++i) {
    auto node_stream =
        stream.substream(static_cast<std::uint64_t>(3 * subdomain.layout.number[i / 3]) + i % 3);
    current[i] = node_stream.uniform(-1, 1);
  }
  const double length = std::sqrt(parallel::exact_dot(group, current, current));
  for (auto& value : current) value /= length;

  Exchange exchange(group, subdomain.layout);
  std::vector<double> displacement(3 * subdomain.nodes.size()), internal(displacement.size());
  std::vector<double> alpha, beta;
  double estimate = 0;
  for (int step = 0; step < max_lanczos_steps; ++step) {
    for (std::size_t i = 0; i < n; ++i) displacement[i] = scale[i] * current[i];
    parallel::check_peers(group);
    update_ghosts(exchange, displacement);
    force(std::span<const double>(displacement), std::span(internal));
    for (std::size_t i = 0; i < n; ++i) next[i] = scale[i] * internal[i];
    alpha.push_back(parallel::exact_dot(group, next, current));
    for (std::size_t i = 0; i < n; ++i) {
      next[i] -= alpha.back() * current[i] + (beta.empty() ? 0 : beta.back()) * previous[i];
    }
    beta.push_back(std::sqrt(parallel::exact_dot(group, next, next)));

    const auto size = static_cast<Eigen::Index>(alpha.size());
    Eigen::VectorXd diagonal = Eigen::Map<Eigen::VectorXd>(alpha.data(), size);
    Eigen::VectorXd off_diagonal = Eigen::Map<Eigen::VectorXd>(beta.data(), size - 1);
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
    solver.computeFromTridiagonal(diagonal, off_diagonal);
    const double residual = beta.back() * std::abs(solver.eigenvectors()(size - 1, size - 1));
    estimate = solver.eigenvalues()[size - 1] + residual;
    if (residual <= lanczos_tolerance * estimate || beta.back() == 0) break;
    for (std::size_t i = 0; i < n; ++i) {
      previous[i] = current[i];
      current[i] = next[i] / beta.back();
    }
  }
  return std::sqrt(estimate);
}

}  // namespace

double largest_frequency(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                         const mechanics::PdsOperators& operators, const mechanics::InternalForce& force) {
  return largest_frequency_of(group, subdomain, operators, [&](auto displacement, auto internal) {
    force.evaluate(displacement, internal);
  });
}

double stable_step(const parallel::Communicator& group, input::Integrator integrator,
                   const input::BulkViscosity& bulk, const geometry::Subdomain& subdomain,
                   const mechanics::PdsOperators& operators, const mechanics::MaterialField& material,
                   const mechanics::InternalForce& force, std::span<const mechanics::NodeStiffness> springs) {
  const auto stiffness = [&](std::span<const double> displacement, std::span<double> internal) {
    force.evaluate(displacement, internal);
    mechanics::add_forces(springs, displacement, internal);
  };
  const double frequency = largest_frequency_of(group, subdomain, operators, stiffness);
  const double undamped = splitting(integrator).stability_limit / frequency;
  if (!bulk.acts()) return undamped;
  // With the rate of the last step, Verlet's scheme M (u+ - 2 u + u-) + dt^2 K u + dt C (u - u-) = 0 is
  // stable while dt^2 K + 2 dt C < 4 M: for one frequency, dt < 2 / omega (sqrt(1 + xi^2) - xi), as in
  // Abaqus/Explicit. Within its own limit "bilateral4" is then stable, too. K + 2 C / dt falls with dt, but
  // dt (K + 2 C / dt) rises, which gives lower bounds on the limit from a longer and from a shorter step.
  const ViscousForce viscosity(subdomain, operators, material, bulk);
  const auto frequency_for = [&](double step) {
    return largest_frequency_of(group, subdomain, operators, [&](auto displacement, auto internal) {
      stiffness(displacement, internal);
      viscosity.add_largest(2 / step, displacement, internal);
    });
  };
  const double too_long = 2 / frequency;
  const double at_long = frequency_for(too_long);
  double step = 4 / (too_long * at_long * at_long);
  for (double last = 0; step > 1.01 * last;) {
    last = step;
    step = 2 / frequency_for(last);
  }
  return std::min(undamped, step);
}

StableStep stable_step(const input::Model& model, const geometry::Realization& realization) {
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto subdomain = geometry::split(realization, geometry::partition(realization, 1)).front();
  const auto material = fracture::make_material_field(model, 0, fracture::span_of(subdomain));
  auto operators = mechanics::make_operators(subdomain, material.density);
  const mechanics::ResidualStiffness intact(operators, material.elasticity);
  const mechanics::InternalForce force(operators, intact);
  const auto scaling = scale_masses(self, model, subdomain, operators, material, force);
  std::vector<mechanics::NodeStiffness> springs;
  if (const auto contact = model.any_contact())
    springs = largest_contact(self, model, subdomain, operators,
                              contact_scale(self, subdomain, operators, force, *contact));
  return {stable_step(self, model.time.integrator, model.bulk_viscosity(), subdomain, operators, material,
                      force, springs),
          scaling};
}

TimeGrid choose_time_grid(const input::Time& time, double stable_step) {
  if (!(stable_step > 0) || !std::isfinite(stable_step))
    fail("the stable time step of the mesh is {} s, too small to compute with", stable_step);
  const int cycle = splitting(time.integrator).steps_per_cycle;
  const auto whole_cycles = [cycle](double steps) {
    return cycle * static_cast<std::int64_t>(std::ceil(steps / cycle * (1 - 1e-12)));
  };
  if (!time.step) {
    const std::int64_t n_steps = whole_cycles(time.duration / (fraction_of_stable_step * stable_step));
    return {time.duration / static_cast<double>(n_steps), n_steps};
  }
  if (*time.step > stable_step) {
    fail(
        "time.step: {:.4g} ns exceeds the stable step of this mesh, {:.4g} ns; give a smaller one, or "
        "\"auto\"",
        1e9 * *time.step, 1e9 * stable_step);
  }
  return {*time.step, whole_cycles(time.duration / *time.step)};
}

}  // namespace crackle::dynamics
