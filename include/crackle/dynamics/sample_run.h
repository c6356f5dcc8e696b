// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/sample_result.h"
#include "crackle/geometry/subdomain.h"
#include "crackle/input/parameters.h"
#include "crackle/parallel/communicator.h"

#include <functional>
#include <string>

namespace crackle::dynamics {

/// One line about the sample's progress ("t0 = 76.2 s, 381 N, dynamic phase 3 starts"); called on the root
/// only.
using SampleLog = std::function<void(const std::string& line)>;

/// One body's way from the unloaded state to its end: quasi-static loading, run-away, dynamic breaking,
/// arrest. Collective over the group; a failure on one rank is thrown on all.
/// @param subdomain this rank's part of the realization
SampleResult run_sample(const parallel::Communicator& group, const input::Parameters& parameters,
                        const geometry::Subdomain& subdomain, const SampleLog& log = {});

}  // namespace crackle::dynamics
