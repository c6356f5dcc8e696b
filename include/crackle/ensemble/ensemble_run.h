// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/ensemble/sample_task.h"
#include "crackle/input/parameters.h"
#include "crackle/parallel/communicator.h"

#include <cstdint>
#include <filesystem>
#include <ostream>
#include <string>

namespace crackle::ensemble {

struct RunOptions {
  std::filesystem::path folder;
  bool resume = false;          ///< continue what the folder holds
  std::ostream* log = nullptr;  ///< what people see, written on rank 0; nullptr: nothing
  int terminal_width = 0;       ///< columns, where `log` is a terminal; 0: plain lines
};

/// The same on every rank.
struct RunOutcome {
  int done = 0;
  int failed = 0;
  int left = 0;            ///< pending
  std::string file_error;  ///< why ensemble.h5 could not be written; empty when it was
};

/// Runs the ensemble: rank 0 makes realizations ahead of need and hands them out one at a time, groups of
/// ranks_per_sample ranks compute them, all ranks write ensemble.h5. With one rank, master and worker share
/// it. Collective over `world`.
/// @throws parallel::AgreedError on every rank before anything is computed (unusable folder, too few ranks,
/// body that cannot be meshed)
/// @throws other exceptions on a rank whose messages fail later; the other ranks cannot know, so the caller
/// has to end the program
RunOutcome run_ensemble(const parallel::Communicator& world, const input::Parameters& parameters,
                        const RunOptions& options, const SampleFunction& sample_function);

}  // namespace crackle::ensemble
