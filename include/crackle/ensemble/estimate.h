// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/stable_step.h"
#include "crackle/ensemble/measured_cost.h"
#include "crackle/input/parameters.h"

#include <cstdint>

namespace crackle::ensemble {

/// Default number of dynamic phases of a sample that starts quasi-statically; the last one runs for the full
/// duration. Samples of jobs/demo.toml have 1 to 6 (mean 3.3), those of jobs/paper/clock-from-zero.toml 1.5
/// on average.
inline constexpr int usual_phases = 2;

/// The smallest and the largest number of dynamic phases to expect.
struct PhaseRange {
  int least = usual_phases, most = usual_phases;
};

/// More than the usual number where a growing crack relieves the load, so that it arrests and starts again:
/// between moved grips, up to 10, and under a stress that changes with time, such as a thermal one, up to 60
/// (a disc shrunk into a ring: 34 to 57).
PhaseRange expected_phases(const input::Parameters& parameters);

/// Work of one dynamic phase of full duration.
struct PhaseWork {
  dynamics::TimeGrid grid{};
  std::int64_t force_evaluations = 0;
};

/// @param stable_step of the realization and the integrator [s]
/// @throws std::runtime_error naming time.step and the stable step when time.step exceeds the stable step
PhaseWork phase_work(const input::Parameters& parameters, double stable_step);

/// Expected dynamic phases and static solves of a sample.
struct SampleWork {
  int phases = 1;             ///< the last one runs for the full duration
  int phases_unbroken = 0;    ///< the same of a body that does not break
  double full_durations = 1;  ///< total dynamic time, in units of the full duration
  int solves = 0;             ///< equilibria after the first; 0 with start = "rest"
};

/// @param arrest_window see dynamics::arrest_window [s]
/// @param phases of a sample with start = "quasi-static"; ignored with start = "rest", which has one
SampleWork sample_work(const input::Parameters& parameters, double arrest_window, int phases = usual_phases);

/// One-core time of a sample [s].
struct SampleCost {
  double phase = 0;         ///< one dynamic phase of the full duration
  double dynamic = 0;       ///< all dynamic phases
  double quasi_static = 0;  ///< all equilibria
  double rest = 0;          ///< meshing, set-up, crack analysis and output
  double total() const { return dynamic + quasi_static + rest; }
};

/// @param rest meshing, crack analysis and output [s]
SampleCost sample_cost(const MeasuredCost& measured, const PhaseWork& phase, const SampleWork& work,
                       double rest);

/// Size of a sample file [byte], compressed; accurate to about 25 % for a sample that cracks.
double sample_file_size(const input::Parameters& parameters, double n_nodes, double n_tetrahedra);

/// Size of ensemble.h5 [byte].
double ensemble_file_size(const input::Parameters& parameters, double n_nodes);

}  // namespace crackle::ensemble
