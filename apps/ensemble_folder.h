// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/sample_summary.h"
#include "analysis/statistics.h"
#include "input/parameters.h"
#include "parallel/communicator.h"

#include <filesystem>
#include <string>
#include <vector>

namespace crackle::apps {

/// The rows of an ensemble, one per sample, and remarks on the files they come from.
struct StoredSamples {
  std::vector<analysis::SampleSummary> rows;
  analysis::Origin origin;
};

/// The folder of an ensemble, from the folder itself or its ensemble.h5. Collective.
/// @throws parallel::AgreedError for another file
std::filesystem::path folder_of(const parallel::Communicator& world, const std::filesystem::path& given);

/// Prints on standard error why the file of a sample cannot be used, if it cannot.
void tell_unusable(std::size_t sample, const analysis::SampleSummary& row);

/// The rows of a read-only ensemble: those of ensemble.h5, and of sample files not yet included.
StoredSamples stored_samples(const std::filesystem::path& folder, const input::Parameters& parameters);

/// Results missing from the folder's files if these are of an older format; a note if they are of another
/// model than this program's.
analysis::Origin origin_of(const std::filesystem::path& folder);

/// The input with which the ensemble in `folder` was started: the run's copy of it, or the one stored with
/// its results. Collective.
/// @throws parallel::AgreedError on every rank when the folder contains no ensemble
input::Parameters input_of(const parallel::Communicator& world, const std::filesystem::path& folder);

/// One of several ensembles, with its samples that count.
struct StoredEnsemble {
  input::Parameters parameters;
  StoredSamples samples;
};

/// The ensembles in these folders, or with these ensemble.h5; their samples on the root only. Collective.
/// @throws parallel::AgreedError also for one without completed samples
std::vector<StoredEnsemble> stored_ensembles(const parallel::Communicator& world,
                                             const std::vector<std::string>& folders);

}  // namespace crackle::apps
