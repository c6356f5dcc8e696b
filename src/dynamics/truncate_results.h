// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/sample_result.h"

namespace crackle::dynamics {

/// Drops breaks, energy rows and history rows after the counted time of the last dynamic phase: they only
/// served to show that it was the last one. Everything counts if loading continued after it.
/// @param end_time since the start of the last phase [s]
void truncate_results(SampleResult& result, double end_time);

}  // namespace crackle::dynamics
