// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/estimate.h"

#include "crackle/dynamics/integrator.h"
#include "crackle/dynamics/stable_step.h"

#include <cmath>

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

Estimate make_estimate(const input::Parameters& parameters, std::int64_t n_nodes, std::int64_t n_tetrahedra,
                       double stable_step) {
  const dynamics::TimeGrid grid = dynamics::choose_time_grid(parameters.time, stable_step);
  Estimate estimate;
  estimate.step = grid.step;
  estimate.steps = grid.n_steps;
  estimate.force_evaluations = static_cast<std::int64_t>(std::ceil(
      dynamics::splitting(parameters.time.integrator).forces_per_step * static_cast<double>(grid.n_steps)));
  estimate.sample_memory = static_cast<double>(n_nodes) * bytes_per_node +
                           static_cast<double>(n_tetrahedra) * bytes_per_tetrahedron +
                           parameters.ensemble.ranks_per_sample * bytes_per_rank;
  const double updates = static_cast<double>(estimate.force_evaluations) * static_cast<double>(n_tetrahedra);
  estimate.core_hours =
      parameters.ensemble.samples * updates / updates_per_core_second(parameters.time.precision) / 3600;
  return estimate;
}

}  // namespace crackle::ensemble
