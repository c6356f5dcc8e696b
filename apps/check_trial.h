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
std::vector<std::string> try_samples(const FirstSample& subject, const geometry::MotherPoints& base,
                                     const TrialExtent& extent);

/// Starts more samples, as many as ten seconds allow, where the stress of sample 0 at time 0 is so near the
/// strength that others may exceed it; says how many would fail.
/// @param share of stress in strength in sample 0, the largest
/// @return the first reason of a failure, if any
std::vector<std::string> try_scatter_at_start(const FirstSample& subject, const geometry::MotherPoints& base,
                                              double share);

}  // namespace crackle::apps
