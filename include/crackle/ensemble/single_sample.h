// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"
#include "crackle/ensemble/sample_task.h"
#include "crackle/ensemble/stop_request.h"
#include "crackle/input/parameters.h"
#include "crackle/parallel/communicator.h"

#include <cstdint>
#include <filesystem>

namespace crackle::ensemble {

struct SingleSampleOptions {
  std::filesystem::path folder;
  std::uint64_t sample = 0;
  bool resume = false;        ///< keep a whole file, go on from a checkpoint; otherwise there must be neither
  bool retry_failed = false;  ///< with `resume`: computed again when it failed
  bool overwrite = false;     ///< without `resume`: file and checkpoint go first
  StopRequest stop{};         ///< looked at on every rank; may be empty
  double checkpoint_interval = infinity;  ///< wall time [s]
  dynamics::SampleLog progress{};         ///< see dynamics::SampleControl; on rank 0
};

/// Computes one sample of the ensemble with all ranks as one group, and writes its file to `folder`/samples.
/// The sample is locked meanwhile. Collective over `ranks`.
/// @param log lines about the sample's progress; on rank 0
/// @return the sample's report on rank 0; elsewhere only its status and whether it was parked, as on rank 0
/// @throws parallel::AgreedError on every rank before anything is computed or written (no such sample,
/// unusable folder, another input, a file or checkpoint that is in the way, body that cannot be meshed)
/// @throws other exceptions on a rank whose messages fail later; the other ranks cannot know, so the caller
/// has to end the program
SampleReport run_single_sample(const parallel::Communicator& ranks, const input::Parameters& parameters,
                               const SingleSampleOptions& options, const SampleFunction& sample_function,
                               const dynamics::SampleLog& log);

}  // namespace crackle::ensemble
