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

/// Command lines that the end of the log names, for what is left to do.
struct NextCommands {
  std::string resume;        ///< continues with pending samples
  std::string retry_failed;  ///< computes failed ones again
  std::string report;        ///< makes pictures and report of what there is
};

struct RunOptions {
  std::filesystem::path folder;
  PlanOptions plan{};           ///< what is done with what the folder holds
  std::ostream* log = nullptr;  ///< what people see, written on rank 0; nullptr: nothing
  int terminal_width = 0;       ///< columns, where `log` is a terminal; 0: plain lines
  StopRequest stop{};           ///< looked at on every rank; may be empty
  /// SampleSteps::enter; may be empty.
  std::function<void(std::uint64_t sample, std::string_view stage)> enter{};
  double checkpoint_interval = infinity;  ///< of a sample, wall time [s]
  NextCommands next{};                    ///< empty ones are not named
};

/// The same on every rank.
struct RunOutcome {
  int done = 0;
  int failed = 0;
  int left = 0;            ///< pending
  bool stopped = false;    ///< on a request, with samples left
  bool lost = false;       ///< the folder was moved or removed meanwhile
  std::string file_error;  ///< why ensemble.h5 could not be written; empty when it was
  std::vector<analysis::SampleSummary> rows = {};  ///< on the root, as ensemble.h5 has them; none of a range
};

/// Runs the ensemble: rank 0 makes realizations ahead of need and hands them out one at a time, groups of
/// ranks_per_sample ranks compute them, all ranks write ensemble.h5. With one rank, master and worker share
/// it. The folder is locked meanwhile. A run of a range of samples writes no ensemble.h5. Collective over
/// `world`.
/// @throws parallel::AgreedError on every rank before anything is computed (unusable folder, too few ranks,
/// body that cannot be meshed)
/// @throws other exceptions on a rank whose messages fail later; the other ranks cannot know, so the caller
/// has to end the program
RunOutcome run_ensemble(const parallel::Communicator& world, const input::Parameters& parameters,
                        const RunOptions& options, const SampleFunction& sample_function);

}  // namespace crackle::ensemble
