// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/ensemble/sample_task.h"
#include "crackle/input/parameters.h"
#include "crackle/parallel/communicator.h"

#include <cstdint>
#include <filesystem>

namespace crackle::ensemble {

/// Computes one sample of the ensemble with all ranks as one group, and writes its file to `folder`/samples.
/// Collective over `ranks`.
/// @param log lines about the sample's progress; on rank 0
/// @return the sample's report on rank 0; elsewhere only its status, the same as on rank 0
/// @throws parallel::AgreedError on every rank before anything is computed or written (no such sample,
/// unusable folder, body that cannot be meshed)
/// @throws other exceptions on a rank whose messages fail later; the other ranks cannot know, so the caller
/// has to end the program
SampleReport run_single_sample(const parallel::Communicator& ranks, const input::Parameters& parameters,
                               const std::filesystem::path& folder, std::uint64_t sample,
                               const SampleFunction& sample_function, const dynamics::SampleLog& log);

}  // namespace crackle::ensemble
