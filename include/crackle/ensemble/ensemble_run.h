// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/sample_run.h"
#include "crackle/input/parameters.h"
#include "crackle/parallel/communicator.h"

#include <filesystem>
#include <functional>

namespace crackle::ensemble {

/// The mechanics of one sample, as dynamics::run_sample; a parameter so that tests can inject faults.
using SampleFunction = std::function<dynamics::SampleResult(
    const parallel::Communicator& group, std::uint64_t sample, const geometry::Subdomain& subdomain,
    const dynamics::SampleLog& log)>;

struct RunOptions {
  std::filesystem::path folder;
  bool resume = false;
};

struct RunOutcome {
  int done = 0;
  int failed = 0;
  int left = 0;
};

/// Runs the ensemble: rank 0 makes realizations ahead of need and hands them out one at a time, groups of
/// ranks_per_sample ranks compute them, all ranks write ensemble.h5. With one rank, master and worker share
/// it. Collective over `world`.
/// @throws the same exception on every rank (unusable folder, body that cannot be meshed)
RunOutcome run_ensemble(const parallel::Communicator& world, const input::Parameters& parameters,
                        const RunOptions& options, const SampleFunction& sample_function);

}  // namespace crackle::ensemble
