// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/sample_summary.h"
#include "analysis/statistics.h"
#include "geometry/mother_points.h"
#include "input/parameters.h"
#include "parallel/communicator.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

/// Collects the results of an ensemble from its sample files into ensemble.h5.
namespace crackle::ensemble {

/// folder/ensemble.h5
std::filesystem::path results_file(const std::filesystem::path& folder);

/// True for ensemble.h5 and for its temporary file.
bool is_of_results(const std::filesystem::path& file);

/// Refuses a folder in which the name of ensemble.h5 or of its lock is taken by something that must not be
/// replaced.
/// @throws std::runtime_error naming it, with advice
void check_results(const std::filesystem::path& folder);

struct Results {
  /// On the root: rows of all samples; those outside the ensemble are pending.
  std::vector<analysis::SampleSummary> rows;
  analysis::Statistics statistics;  ///< on the root
  std::string file_error;           ///< on every rank: why ensemble.h5 could not be written; empty on success
};

/// Treatment of rows of ensemble.h5 whose sample files are missing.
enum class MissingFiles {
  drop_rows,  ///< the samples are pending
  keep_rows,  ///< kept: the files were moved away
};

/// Reads the rows back from the sample files and writes them with their statistics to ensemble.h5. A lock,
/// folder/lock-ensemble.h5, prevents concurrent writes, so that older rows never replace newer ones; waits if
/// another process holds it. Removes temporary files left by killed writers of ensemble.h5. Collective.
/// @param unstored on the root: failures not recorded in any sample file
/// @param base on the root: the base mother points
/// @throws parallel::AgreedError on every rank when the sample files cannot be read, or ensemble.h5 if rows
///   of it are to be kept
Results write_results(const parallel::Communicator& world, const input::Parameters& parameters,
                      const std::filesystem::path& folder,
                      const std::map<std::uint64_t, analysis::SampleSummary>& unstored,
                      const std::function<const geometry::MotherPoints&()>& base,
                      MissingFiles missing = MissingFiles::drop_rows);

/// The rows of an ensemble with the crossings at other sections, computed from the crack surfaces in its
/// sample files, and their statistics. The set of samples that count remains that of the existing ensemble,
/// even if [ensemble.stop] would have required others for these sections. Writes nothing. Collective.
/// @param parameters that the ensemble was computed with
/// @param sections the same with other sections, input::with_sections
/// @throws parallel::AgreedError on every rank when there are no sample files
Results results_at(const parallel::Communicator& world, const input::Parameters& parameters,
                   const input::Study& sections, const std::filesystem::path& folder);

}  // namespace crackle::ensemble
