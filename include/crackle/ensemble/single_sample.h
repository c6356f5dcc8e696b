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
  bool resume = false;  ///< keep a complete file or continue from a checkpoint; otherwise neither may exist
  bool retry_failed = false;              ///< with `resume`: recompute the sample if it failed
  bool overwrite = false;                 ///< without `resume`: delete file and checkpoint first
  StopRequest stop{};                     ///< polled on every rank; may be empty
  double checkpoint_interval = infinity;  ///< wall time [s]
  dynamics::SampleLog progress{};         ///< see dynamics::SampleControl; on rank 0
};

/// Computes one sample of the ensemble with all ranks as one group, and writes its file to `folder`/samples.
/// The sample is locked during the run. Collective over `ranks`.
/// @param log lines about the sample's progress; on rank 0
/// @return the sample's report on rank 0; elsewhere only its status and whether it was parked, as on rank 0
/// @throws parallel::AgreedError on every rank before anything is computed or written (no such sample,
///   unusable folder, another input, existing file or checkpoint, body that cannot be meshed)
/// @throws other exceptions on a rank whose communication fails later; the other ranks cannot know, so the
///   caller must abort the program
SampleReport run_single_sample(const parallel::Communicator& ranks, const input::Parameters& parameters,
                               const SingleSampleOptions& options, const SampleFunction& sample_function,
                               const dynamics::SampleLog& log);

}  // namespace crackle::ensemble
