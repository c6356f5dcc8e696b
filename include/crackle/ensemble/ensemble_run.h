// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"
#include "crackle/common/real.h"
#include "crackle/ensemble/sample_plan.h"
#include "crackle/ensemble/sample_task.h"
#include "crackle/ensemble/stop_request.h"
#include "crackle/input/parameters.h"
#include "crackle/parallel/communicator.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

namespace crackle::ensemble {

/// Commands suggested at the end of the log.
struct NextCommands {
  std::string resume;        ///< continues with pending samples
  std::string retry_failed;  ///< recomputes failed ones
  std::string report;        ///< makes figures and a report from the available results
};

struct RunOptions {
  std::filesystem::path folder;
  PlanOptions plan{};           ///< how existing contents of the folder are treated
  std::ostream* log = nullptr;  ///< messages to the user, written on rank 0; nullptr: none
  int terminal_width = 0;       ///< columns if `log` is a terminal; 0: plain lines
  StopRequest stop{};           ///< polled on every rank; may be empty
  /// SampleSteps::enter; may be empty.
  std::function<void(std::uint64_t sample, std::string_view stage)> enter{};
  double checkpoint_interval = infinity;  ///< of a sample, wall time [s]
  NextCommands next{};                    ///< empty ones are not shown
};

/// The same on every rank.
struct RunOutcome {
  int done = 0;
  int failed = 0;
  int left = 0;            ///< pending
  bool stopped = false;    ///< on request, with samples left
  bool lost = false;       ///< the folder was moved or removed during the run
  std::string file_error;  ///< why ensemble.h5 could not be written; empty on success
  std::vector<analysis::SampleSummary> rows =
      {};  ///< on the root, as in ensemble.h5; empty for a run of a range
};

/// Runs the ensemble: rank 0 makes realizations ahead of need and hands them out one at a time, groups of
/// ranks_per_sample ranks compute them, all ranks write ensemble.h5. With a single rank, it is both master
/// and worker. The folder is locked during the run. A run of a range of samples writes no ensemble.h5.
/// Collective over `world`.
/// @throws parallel::AgreedError on every rank before anything is computed (unusable folder, too few ranks,
/// body that cannot be meshed)
/// @throws other exceptions on a rank whose communication fails later; the other ranks cannot know, so the
///   caller must abort the program
RunOutcome run_ensemble(const parallel::Communicator& world, const input::Parameters& parameters,
                        const RunOptions& options, const SampleFunction& sample_function);

}  // namespace crackle::ensemble
