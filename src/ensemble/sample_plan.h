// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/sample_summary.h"
#include "ensemble/folder_lock.h"
#include "input/parameters.h"
#include "input/reader.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace crackle::ensemble {

/// A sample that ended in an earlier run, done or failed.
struct KeptSample {
  std::uint64_t sample;
  analysis::SampleSummary summary;
};

/// A damaged or foreign sample file or checkpoint.
struct InvalidFile {
  std::filesystem::path file;
  std::string reason;
};

/// The samples that a run computes.
struct SamplePlan {
  SampleRange range;                     ///< samples that this run may compute
  std::vector<std::uint64_t> to_do;      ///< ascending
  std::vector<KeptSample> kept;          ///< ascending
  std::vector<std::uint64_t> suspended;  ///< subset of to_do with a checkpoint to continue from
  std::vector<std::uint64_t> anew;       ///< subset of to_do whose file and checkpoint are deleted first
  std::vector<InvalidFile> invalid;      ///< their samples are in to_do
};

/// Reads the row of a sample from its file; throws if the file is incomplete or belongs to another input or
/// sample.
using SummaryReader =
    std::function<analysis::SampleSummary(const std::filesystem::path& file, std::uint64_t sample)>;

/// io::read_summary for these parameters, which must outlive it.
SummaryReader summary_reader(const input::Parameters& parameters);

/// How a run treats existing contents of its folder.
struct PlanOptions {
  bool resume = false;                 ///< continue it; otherwise the folder must not contain an ensemble
  bool retry_failed = false;           ///< recompute samples that failed
  std::optional<SampleRange> range{};  ///< only these samples; empty: all
  /// Only this sample, for plan_sample().
  std::optional<std::uint64_t> single{};
  bool overwrite = false;  ///< of a single sample, without `resume`: delete its file and checkpoint first
};

/// Part `number`, from 0, of `n_parts` ranges that differ by at most one sample and make up the ensemble.
/// @pre number < n_parts
/// @throws std::runtime_error when there are more parts than samples
SampleRange part_of_samples(std::uint64_t number, std::uint64_t n_parts, std::uint64_t n_samples);

/// Refuses a folder that this run must not use. Reads only.
/// @throws std::runtime_error when the path is not a folder, contains an ensemble and `resume` is not set, or
///   contains one of another input; or when the range exceeds the ensemble
void check_folder(const std::filesystem::path& folder, const input::Parameters& parameters,
                  const PlanOptions& options);

/// All samples of the range; with `resume` only those without a complete file in folder/samples, where failed
/// ones count as ended. Reads only. @throws std::runtime_error as check_folder
SamplePlan make_plan(const std::filesystem::path& folder, const input::Parameters& parameters,
                     const PlanOptions& options, const SummaryReader& read);

/// @throws std::runtime_error if the ensemble of the input has no sample of this number
void require_sample(const input::Ensemble& ensemble, std::uint64_t sample);

/// The work on options.single, whatever else the folder holds of the ensemble. Without `resume` and
/// `overwrite`, neither a file nor a checkpoint of the sample may exist. Reads only.
/// @throws std::runtime_error as check_folder, and when there is no such sample
SamplePlan plan_sample(const std::filesystem::path& folder, const input::Parameters& parameters,
                       const PlanOptions& options);

/// Creates folder/samples. @throws std::runtime_error naming the folder that cannot be created
void make_sample_folder(const std::filesystem::path& folder);

/// The copies of the files of mesh.points and specimen.solid in an ensemble's folder.
std::filesystem::path points_copy(const std::filesystem::path& folder);
std::filesystem::path solid_copy(const std::filesystem::path& folder, const std::string& extension);
/// Those that are there.
input::GivenFiles copied_files(const std::filesystem::path& folder);

/// Creates the folders, renames invalid files (0003.h5.invalid-1), removes checkpoints of samples that have
/// ended, all files of samples that begin anew and temporary files of killed runs (except those of
/// ensemble.h5, see write_results), and stores the input text in folder/input.toml and the files that it
/// names in points_copy and solid_copy.
/// @pre the samples of the plan are locked
/// @return one line for each renamed file, with the reason and the new name
/// @throws std::runtime_error naming what cannot be written
std::vector<std::string> prepare_folder(const std::filesystem::path& folder,
                                        const input::Parameters& parameters, const SamplePlan& plan);

/// Rewrites folder/input.toml and the copies of other files if they were removed during the run. @return true
/// if anything was rewritten
/// @throws std::runtime_error naming what cannot be written
bool restore_input(const std::filesystem::path& folder, const input::Parameters& parameters);

/// Renames a file to an unused name such as 0003.h5.invalid-1. @return the new name
/// @throws std::filesystem::filesystem_error
std::filesystem::path set_aside(const std::filesystem::path& file);

/// Refuses a folder whose input.toml does not match the parameters, or whose copy of mesh.points or
/// specimen.solid has different contents. The same samples of a larger ensemble are accepted as its
/// continuation.
/// @throws std::runtime_error with the settings that differ
void check_same_input(const std::filesystem::path& folder, const input::Parameters& parameters);

/// The first line in which two texts differ, as "line 3 is 'a', not 'b'"; empty if they are equal.
std::optional<std::string> first_difference(const std::string& expected, const std::string& actual);

}  // namespace crackle::ensemble
