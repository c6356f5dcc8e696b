// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/ensemble/estimate.h"

#include "check_subject.h"

#include <cstdint>
#include <optional>

namespace crackle::apps {

/// One-core time of a sample, and what it is in proportion to.
struct SampleTime {
  ensemble::SampleCost cost;
  double n_tetrahedra = 0;
  std::int64_t force_evaluations = 0;  ///< of a dynamic phase
  double share_at_start = 0;           ///< of stress in strength at time 0, the largest
};

/// Measures the cost of sample 0 on this machine and prints it.
/// @param phases expected number of dynamic phases; 0: as such inputs have
/// @param n_ranks number of ranks to plan for; 0: no plan
/// @return nothing if it could not be measured
/// @throws std::runtime_error with the reason if the sample will fail
std::optional<SampleTime> print_cost(const FirstSample& subject, int phases, std::int64_t n_ranks);

/// One-core time of a sample that differs from the measured one in its mesh, expected number of dynamic
/// phases and equilibria excepted [s].
double scaled_seconds(const SampleTime& measured, const FirstSample& subject);

/// Warns if loads from rest are far from breaking the body.
void print_rest_outlook(const FirstSample& subject);

}  // namespace crackle::apps
