// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"
#include "crackle/analysis/statistics.h"
#include "crackle/geometry/mother_points.h"
#include "crackle/input/parameters.h"
#include "crackle/parallel/communicator.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

/// The end of an ensemble: what its sample files say, in ensemble.h5.
namespace crackle::ensemble {

/// folder/ensemble.h5
std::filesystem::path results_file(const std::filesystem::path& folder);

/// Whether a file of the folder is ensemble.h5, or one that becomes it when it is whole.
bool is_of_results(const std::filesystem::path& file);

/// Refuses a folder in which ensemble.h5 or its lock has the name of something that must not be replaced.
/// @throws std::runtime_error naming it, and what to do
void check_results(const std::filesystem::path& folder);

struct Results {
  /// On the root: of all samples, those that are no part of the ensemble pending.
  std::vector<analysis::SampleSummary> rows;
  analysis::Statistics statistics;  ///< on the root
  std::string file_error;  ///< on every rank: why ensemble.h5 could not be written; empty when it was
};

/// What becomes of the rows of ensemble.h5 whose sample files are gone.
enum class MissingFiles {
  drop_rows,  ///< the samples are pending
  keep_rows,  ///< they stay: the files were moved away
};

/// Reads the rows back from the sample files and writes them with their statistics to ensemble.h5. Meanwhile
/// a lock, folder/lock-ensemble.h5, keeps others from doing the same, so that older rows never replace newer
/// ones; another's lock is waited for. Removes what killed writers of ensemble.h5 have left. Collective.
/// @param unstored on the root: failures that no sample file tells of
/// @param base on the root: the base mother points
/// @throws parallel::AgreedError on every rank when the sample files cannot be read, or ensemble.h5, where
/// rows of it are to stay
Results write_results(const parallel::Communicator& world, const input::Parameters& parameters,
                      const std::filesystem::path& folder,
                      const std::map<std::uint64_t, analysis::SampleSummary>& unstored,
                      const std::function<const geometry::MotherPoints&()>& base,
                      MissingFiles missing = MissingFiles::drop_rows);

/// The rows of an ensemble with their crossings at other sections, from the crack surfaces in its sample
/// files, and the statistics of these. The samples that count are those of the ensemble as it is, also where
/// [ensemble.stop] would have needed others for these sections. Writes nothing. Collective.
/// @param parameters that the ensemble was computed with
/// @param sections the same with other sections, input::with_sections
/// @throws parallel::AgreedError on every rank when there are no sample files
Results results_at(const parallel::Communicator& world, const input::Parameters& parameters,
                   const input::Parameters& sections, const std::filesystem::path& folder);

}  // namespace crackle::ensemble
