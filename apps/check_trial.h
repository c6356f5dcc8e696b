// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/ensemble/trial.h"
#include "crackle/geometry/mother_points.h"

#include "check_subject.h"

#include <cstdint>
#include <string>
#include <vector>

namespace crackle::apps {

/// How many samples are tried, and how far.
struct TrialExtent {
  std::int64_t samples = 0;  ///< 0: sample 0 only
  ensemble::TrialDepth depth = ensemble::TrialDepth::start;
};

/// Tries samples as a run would; says how many would fail if their number was asked for.
/// @param base the shared mother points
/// @return reasons of failures, each with its sample number; empty if there are none
std::vector<std::string> try_samples(const Subject& subject, const geometry::MotherPoints& base,
                                     const TrialExtent& extent);

}  // namespace crackle::apps
