// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"
#include "crackle/ensemble/folder_lock.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace crackle::ensemble {

/// A sample that an earlier run has ended, done or failed.
struct KeptSample {
  std::uint64_t sample;
  analysis::SampleSummary summary;
};

/// A sample file or checkpoint that cannot be trusted.
struct InvalidFile {
  std::filesystem::path file;
  std::string reason;
};

/// Which samples a run computes.
struct SamplePlan {
  SampleRange range;                  ///< of the samples that this run may compute
  std::vector<std::uint64_t> to_do;   ///< ascending
  std::vector<KeptSample> kept;       ///< ascending
  std::vector<std::uint64_t> parked;  ///< of to_do, those with a checkpoint to continue from
  std::vector<std::uint64_t> anew;    ///< of to_do, those whose file and checkpoint go first
  std::vector<InvalidFile> invalid;   ///< their samples are in to_do
};

/// Reads the row of a sample from its file; throws when the file is not a whole one of this input and number.
using SummaryReader =
    std::function<analysis::SampleSummary(const std::filesystem::path& file, std::uint64_t sample)>;

/// io::read_summary for these parameters, which must outlive it.
SummaryReader summary_reader(const input::Parameters& parameters);

/// What a run does with what its folder holds.
struct PlanOptions {
  bool resume = false;                 ///< continue it; otherwise the folder must hold no ensemble
  bool retry_failed = false;           ///< samples that failed are computed again
  std::optional<SampleRange> range{};  ///< only these samples; empty: all
};

/// Part `number`, from 0, of `n_parts` ranges that differ by one sample at most and make up the ensemble.
/// @pre number < n_parts
/// @throws std::runtime_error when there are more parts than samples
SampleRange part_of_samples(std::uint64_t number, std::uint64_t n_parts, std::uint64_t n_samples);

/// Refuses a folder that this run must not use. Reads only.
/// @throws std::runtime_error when the path is not a folder, holds an ensemble and `resume` is not set, or
/// holds one of another input; or when the range leaves the ensemble
void check_folder(const std::filesystem::path& folder, const input::Parameters& parameters,
                  const PlanOptions& options);

/// All samples of the range; with `resume` only those without a whole file in folder/samples, failed ones
/// counting as ended. Reads only. @throws std::runtime_error as check_folder
SamplePlan make_plan(const std::filesystem::path& folder, const input::Parameters& parameters,
                     const PlanOptions& options, const SummaryReader& read);

/// Makes folder/samples. @throws std::runtime_error naming the folder that cannot be made
void make_sample_folder(const std::filesystem::path& folder);

/// The copy of the file of mesh.points that an ensemble's folder holds.
std::filesystem::path points_copy(const std::filesystem::path& folder);

/// Makes the folders, sets invalid files aside under a name that is free (0003.h5.invalid-1), removes
/// checkpoints of samples that have ended, what there is of samples that begin anew, and what a
/// killed run has left half-written (except of ensemble.h5, see write_results), and keeps the input text in
/// folder/input.toml and the file of mesh.points in points_copy.
/// @pre the samples of the plan are locked
/// @return one line for each file set aside, with the reason and the new name
/// @throws std::runtime_error naming what cannot be written
std::vector<std::string> prepare_folder(const std::filesystem::path& folder,
                                        const input::Parameters& parameters, const SamplePlan& plan);

/// Writes folder/input.toml, and the copy of the points, again where they were removed meanwhile. @return
/// whether it was
/// @throws std::runtime_error naming what cannot be written
bool restore_input(const std::filesystem::path& folder, const input::Parameters& parameters);

/// Sets a file aside under a name that is free, as 0003.h5.invalid-1. @return its new name
/// @throws std::filesystem::filesystem_error
std::filesystem::path set_aside(const std::filesystem::path& file);

/// Refuses a folder whose input.toml is not that of the parameters, or whose copy of mesh.points has another
/// content. The same samples of a larger ensemble are taken as its continuation.
/// @throws std::runtime_error with the settings that differ
void check_same_input(const std::filesystem::path& folder, const input::Parameters& parameters);

/// The first line in which two texts differ, as "line 3 is 'a', not 'b'"; nothing when they are the same.
std::optional<std::string> first_difference(const std::string& expected, const std::string& actual);

}  // namespace crackle::ensemble
