// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/stable_step.h"
#include "crackle/ensemble/measured_cost.h"
#include "crackle/input/parameters.h"

#include <cstdint>

namespace crackle::ensemble {

/// Dynamic phases of a sample that starts quasi-statically, where nothing better is known; the last of them
/// has the full duration. Samples of jobs/demo.toml have 1 to 6, 3.3 in the mean, those of
/// jobs/paper/clock-from-zero.toml 1.5.
inline constexpr int usual_phases = 2;

/// Work of one dynamic phase that lasts for the full duration.
struct PhaseWork {
  dynamics::TimeGrid grid{};
  std::int64_t force_evaluations = 0;
};

/// @param stable_step of the realization and the integrator [s]
/// @throws std::runtime_error naming time.step and the stable step when the input's step is over it
PhaseWork phase_work(const input::Parameters& parameters, double stable_step);

/// Dynamic phases and static solves that a sample is taken to need.
struct SampleWork {
  int phases = 1;             ///< the last one of the full duration
  double full_durations = 1;  ///< that they take together, in durations of a full one
  int solves = 0;             ///< equilibria after the first one; 0 with start = "rest"
};

/// @param phases of a sample with start = "quasi-static"; with start = "rest" there is one
SampleWork sample_work(const input::Parameters& parameters, int phases = usual_phases);

/// Time of one core for a sample [s].
struct SampleCost {
  double phase = 0;         ///< one dynamic phase of the full duration
  double dynamic = 0;       ///< all dynamic phases
  double quasi_static = 0;  ///< all equilibria
  double rest = 0;          ///< mesh, set-up, crack analysis and writing
  double total() const { return dynamic + quasi_static + rest; }
};

/// @param rest mesh, crack analysis and writing [s]
SampleCost sample_cost(const MeasuredCost& measured, const PhaseWork& phase, const SampleWork& work,
                       double rest);

/// Size of one sample's file [byte], compressed; within a quarter of what is written for a sample that
/// cracks.
double sample_file_size(const input::Parameters& parameters, double n_nodes, double n_tetrahedra);

/// Size of ensemble.h5 [byte].
double ensemble_file_size(const input::Parameters& parameters, double n_nodes);

}  // namespace crackle::ensemble
