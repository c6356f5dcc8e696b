// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/estimate.h"

#include "crackle/dynamics/stable_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace crackle::ensemble {

namespace {

// The largest demand is that of the static solve. A node has about 15 neighbours in a Delaunay tessellation,
// so its three rows of the stiffness matrix hold 9 x 16 entries of 12 bytes; the multigrid hierarchy with its
// work matrices takes about as much twice more. Vectors, coordinates and numberings are small beside that.
constexpr double bytes_per_node = 3 * 9 * 16 * 12 + 500;

// Gradients, volume, nodes, damage, flags, and the mesh itself in the realization and in the subdomain.
constexpr double bytes_per_tetrahedron = 400;

// The program with its libraries, for each rank.
constexpr double bytes_per_rank = 80e6;

}  // namespace

int evaluations_per_step(input::Integrator integrator) {
  return integrator == input::Integrator::bilateral4 ? 4 : 1;
}

std::int64_t n_steps(double duration, double step) {
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(duration / step - 1e-6)));
}

Estimate make_estimate(const input::Parameters& parameters, std::int64_t n_nodes, std::int64_t n_tetrahedra,
                       double stable_step) {
  if (!(stable_step > 0) || !std::isfinite(stable_step)) {
    throw std::runtime_error(
        fmt::format("the stable time step of the mesh is {} s; no step can be chosen", stable_step));
  }
  if (parameters.time.step && *parameters.time.step > stable_step) {
    throw std::runtime_error(
        fmt::format("time.step: {:.6g} ns is over the stable step {:.6g} ns of this mesh and integrator; "
                    "give a smaller one "
                    "or \"auto\"",
                    *parameters.time.step * 1e9, stable_step * 1e9));
  }
  Estimate estimate;
  estimate.step = parameters.time.step.value_or(dynamics::automatic_step_fraction * stable_step);
  estimate.steps = n_steps(parameters.time.duration, estimate.step);
  estimate.force_evaluations = estimate.steps * evaluations_per_step(parameters.time.integrator);
  estimate.sample_memory = static_cast<double>(n_nodes) * bytes_per_node +
                           static_cast<double>(n_tetrahedra) * bytes_per_tetrahedron +
                           parameters.ensemble.ranks_per_sample * bytes_per_rank;
  const double updates = static_cast<double>(estimate.force_evaluations) * static_cast<double>(n_tetrahedra);
  estimate.core_hours = parameters.ensemble.samples * updates / updates_per_core_second / 3600;
  return estimate;
}

}  // namespace crackle::ensemble
