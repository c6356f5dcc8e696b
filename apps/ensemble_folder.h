// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"
#include "crackle/analysis/statistics.h"
#include "crackle/input/parameters.h"
#include "crackle/parallel/communicator.h"

#include <filesystem>
#include <vector>

namespace crackle::apps {

/// The rows of an ensemble, a row for each sample, and what is to be known of the files they are from.
struct StoredSamples {
  std::vector<analysis::SampleSummary> rows;
  analysis::Origin origin;
};

/// The folder of an ensemble, where that or its ensemble.h5 is given. Collective.
/// @throws parallel::AgreedError for another file
std::filesystem::path folder_of(const parallel::Communicator& world, const std::filesystem::path& given);

/// Those of an ensemble whose files stay as they are: of ensemble.h5, and of sample files that it does not
/// know yet.
StoredSamples stored_samples(const std::filesystem::path& folder, const input::Parameters& parameters);

/// What the folder's files lack, which may be of an older format.
analysis::Origin origin_of(const std::filesystem::path& folder);

/// The input that the ensemble in `folder` was started with: the run's copy of it, or what its results hold.
/// Collective.
/// @throws parallel::AgreedError on every rank when the folder holds no ensemble
input::Parameters input_of(const parallel::Communicator& world, const std::filesystem::path& folder);

}  // namespace crackle::apps
