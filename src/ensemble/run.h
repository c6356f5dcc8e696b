// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "ensemble/case.h"
#include "ensemble/stop_request.h"
#include "input/reader.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <ostream>
#include <string_view>
#include <vector>

/// Runs ensembles.
namespace crackle::ensemble {

struct RunOptions {
  std::filesystem::path folder;
  PlanOptions plan{};           ///< how existing contents of the folder are treated
  std::ostream* log = nullptr;  ///< messages to the user, written on rank 0; nullptr: none
  int terminal_width = 0;       ///< columns if `log` is a terminal; 0: plain lines
  StopRequest stop{};           ///< polled on every rank; may be empty
  /// SampleSource::enter; may be empty.
  std::function<void(std::uint64_t sample, std::string_view stage)> enter{};
  double checkpoint_interval = infinity;  ///< of a sample, wall time [s]
  NextCommands next{};                    ///< empty ones are not shown
};

/// Runs an ensemble or, with `cases`, a sweep of ensembles from one queue; with options.plan.single only one
/// sample of an ensemble.
///
/// Rank 0 makes realizations ahead of need and hands them out one at a time, groups of ranks_per_sample ranks
/// compute them, all ranks write ensemble.h5. A single rank is both master and worker; a single sample is
/// computed by all ranks. The samples are locked during the run. A run of a range of samples, or of a single
/// one, writes no ensemble.h5.
///
/// Sample n of every case is handed out before sample n + 1, so that cases with the same body can share its
/// mesh; cases with the same base mother points share these. Each case has the output of an ensemble in
/// case_folder(); then sweep_table() is written.
///
/// Collective over `world`.
/// @param parameters of the ensemble; with the sweep, stored as sweep_input()
/// @return of a sweep: the sums over all cases
/// @throws parallel::AgreedError on every rank before anything is computed (unusable folder, too few ranks,
///   body that cannot be meshed)
/// @throws other exceptions on a rank whose communication fails later; the other ranks cannot know, so the
///   caller must abort the program
RunOutcome run(const parallel::Communicator& world, const input::Parameters& parameters,
               const std::vector<input::Case>& cases, const RunOptions& options,
               const Mechanics& mechanics = dynamics::run_sample);

}  // namespace crackle::ensemble
