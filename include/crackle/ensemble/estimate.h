// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"

#include <cstdint>

namespace crackle::ensemble {

/// Tetrahedron updates per second of one core that the estimate reckons with: the force of one tetrahedron
/// with its share of the time step and the breaking check. `tools/benchmark` measures them.
constexpr double updates_per_core_second(input::Precision precision) {
  return precision == input::Precision::mixed ? 320e6 : 200e6;
}

/// What an ensemble will take. One dynamic phase for each sample is reckoned with; phases that arrest and the
/// static solves before them come on top.
struct Estimate {
  double step = 0;                     ///< that will be used [s]
  std::int64_t steps = 0;              ///< of one sample
  std::int64_t force_evaluations = 0;  ///< of one sample
  double core_hours = 0;               ///< of all samples
};

/// @param stable_step of the realization and the integrator [s]
/// @throws std::runtime_error naming time.step and the stable step when the input's step is over it
Estimate make_estimate(const input::Parameters& parameters, std::int64_t n_tetrahedra, double stable_step);

}  // namespace crackle::ensemble
