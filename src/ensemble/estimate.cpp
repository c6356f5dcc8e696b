// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/estimate.h"

#include "crackle/dynamics/integrator.h"
#include "crackle/dynamics/stable_step.h"

#include <cmath>

namespace crackle::ensemble {

Estimate make_estimate(const input::Parameters& parameters, std::int64_t n_tetrahedra, double stable_step) {
  const dynamics::TimeGrid grid = dynamics::choose_time_grid(parameters.time, stable_step);
  Estimate estimate;
  estimate.step = grid.step;
  estimate.steps = grid.n_steps;
  estimate.force_evaluations = static_cast<std::int64_t>(std::ceil(
      dynamics::splitting(parameters.time.integrator).forces_per_step * static_cast<double>(grid.n_steps)));
  const double updates = static_cast<double>(estimate.force_evaluations) * static_cast<double>(n_tetrahedra);
  estimate.core_hours =
      parameters.ensemble.samples * updates / updates_per_core_second(parameters.time.precision) / 3600;
  return estimate;
}

}  // namespace crackle::ensemble
