// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"
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

/// A sample file that cannot be trusted.
struct InvalidFile {
  std::filesystem::path file;
  std::string reason;
};

/// Which samples a run computes.
struct SamplePlan {
  std::vector<std::uint64_t> to_do;  ///< ascending
  std::vector<KeptSample> kept;      ///< ascending
  std::vector<InvalidFile> invalid;  ///< their samples are in to_do
};

/// Reads the row of a sample from its file; throws when the file is not a whole one of this input and number.
using SummaryReader =
    std::function<analysis::SampleSummary(const std::filesystem::path& file, std::uint64_t sample)>;

/// io::read_summary for these parameters, which must outlive it.
SummaryReader summary_reader(const input::Parameters& parameters);

/// All samples; with `resume` only those without a whole file in folder/samples, failed ones counting as
/// ended. Reads only.
/// @throws std::runtime_error when the folder is no folder, holds an ensemble and `resume` is not set, or
/// holds one of another input
SamplePlan make_plan(const std::filesystem::path& folder, const input::Parameters& parameters, bool resume,
                     const SummaryReader& read);

/// Makes folder/samples. @throws std::runtime_error naming the folder that cannot be made
void make_sample_folder(const std::filesystem::path& folder);

/// The copy of the file of mesh.points that an ensemble's folder holds.
std::filesystem::path points_copy(const std::filesystem::path& folder);

/// Makes the folders, sets invalid files aside under a name that is free (0003.h5.invalid-1), and keeps the
/// input text in folder/input.toml and the file of mesh.points in points_copy.
/// @return one line for each file set aside, with the reason and the new name
/// @throws std::runtime_error naming what cannot be written
std::vector<std::string> prepare_folder(const std::filesystem::path& folder,
                                        const input::Parameters& parameters, const SamplePlan& plan);

/// Refuses a folder whose input.toml has another text than the parameters, or whose copy of mesh.points has
/// another content.
/// @throws std::runtime_error with the first line that differs
void check_same_input(const std::filesystem::path& folder, const input::Parameters& parameters);

/// The first line in which two texts differ, as "line 3 is 'a', not 'b'"; nothing when they are the same.
std::optional<std::string> first_difference(const std::string& expected, const std::string& actual);

}  // namespace crackle::ensemble
