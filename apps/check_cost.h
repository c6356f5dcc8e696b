// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "check_subject.h"

#include <cstdint>

namespace crackle::apps {

/// Measures the cost of sample 0 on this machine and prints it.
/// @param phases expected number of dynamic phases
/// @param n_ranks number of ranks to plan for; 0: no plan
/// @throws std::runtime_error with the reason if the sample will fail
void print_cost(const Subject& subject, int phases, std::int64_t n_ranks);

/// Warns if loads from rest are far from breaking the body.
void print_rest_outlook(const Subject& subject);

}  // namespace crackle::apps
