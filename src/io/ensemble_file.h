// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/sample_summary.h"
#include "analysis/statistics.h"
#include "geometry/mother_points.h"
#include "input/parameters.h"
#include "parallel/communicator.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

/// The ensemble's file, out/ensemble.h5. All values are SI; `units` is an attribute of each dataset. N
/// samples, S sections, M mother points:
///
/// | object | shape | meaning |
/// |---|---|---|
/// | attributes of / | | kind, schema_version, program_version, git_commit, library_versions, seed, input,
/// points, input_identity |
/// | /specimen/... | | see geometry::for_each_member |
/// | /samples/status, error, note | N | analysis::SampleStatus; reason of a failure; remarks |
/// | /samples/... | N | the results of analysis::for_each_result |
/// | /crack_path/section | S | where the sections lie |
/// | /crack_path/section_axis | S | 1 y = const first, then 2 z = const, then 0 lines, at `section` 0 |
/// | /crack_path/section_line | lines x 2 x 2 | y, z of the lines' ends; absent without lines |
/// | /crack_path/... | N x notches x S | the results of analysis::for_each_position_result |
/// | /crack_path/z | N x notches x sections y | position at the sections y = const |
/// | /plane_traces/point, normal, axes | planes x 3, 3, 2 x 3 | with [[sections.plane]]: the planes |
/// | /plane_traces/... | N x planes x cracks | the results of analysis::for_each_trace_result |
/// | /plane_traces/cracks | cracks | whose traces: of each crack start, of cracks without one, of all |
/// | /fragments/... | N | the results of analysis::for_each_fragment_result |
/// | /fragments/heavier, shares | N x B, B | FragmentSummary::heavier; analysis::fragment_shares |
/// | /statistics/z_mean, z_std, z_half_width, reached | notches x S | see analysis::Statistics |
/// | /statistics/z_quantile | notches x S x 5 | least, quartiles and median, greatest |
/// | /statistics/running_mean | N x notches x S | |
/// | /statistics/leader, leader/one_crack, ..., follower | | groups of these, rows in place of notches |
/// | .../leading_notch, notch, counted | rows, rows, rows x S | analysis::RankStatistics |
/// | /statistics/reference_notch | notches | see analysis::LeaderFrame |
/// | /statistics/pattern_share, pattern_half_width, pattern_lower, pattern_upper | 4 | |
/// | /statistics/traces/... | planes x cracks | see analysis::TraceStatistics |
/// | /statistics/fragments/NAME_mean, NAME_std, NAME_half_width | | see analysis::FragmentStatistics |
/// | /statistics/fragments/heavier_mean, ..., counted | B, 1 | likewise; samples with known fragments |
/// | attributes confidence, interval_scope, n_looks, n_needed of /statistics | | analysis::Statistics |
/// | /mother_points/position, spacing, movable | M x 3, M, M | absent if each sample has its own |
/// | /timing/wall_time, attributes of /provenance | N | what differs between two runs |
///
/// Attributes of each result's dataset describe its meaning and display, see analysis::ResultInfo.
namespace crackle::io {

/// Incremented with every change of the file's contents.
inline constexpr std::int64_t ensemble_schema_version = 8;

/// Rows first..first+rows.size() of the ensemble, written by one rank.
struct EnsembleBlock {
  std::size_t first = 0;
  std::vector<analysis::SampleSummary> rows;
};

/// Writes ensemble.h5 through MPI-IO; every rank writes its block of rows, and all ranks take part in every
/// collective call, with or without rows. Samples that no rank holds are pending. The file is written under a
/// temporary name and renamed when complete; except for /provenance it does not depend on the distribution of
/// rows over ranks. Collective.
/// @param statistics, base the same on every rank; only the root's are written
/// @throws the same parallel::AgreedError on every rank when blocks overlap or exceed the ensemble, a row
///   does not have the input's shape, or the file cannot be written
void write_ensemble(const parallel::Communicator& world, const std::filesystem::path& file,
                    const input::Parameters& parameters, const EnsembleBlock& block,
                    const analysis::Statistics& statistics, const geometry::MotherPoints& base);

/// Why a file must not be replaced by an ensemble file: "is a folder", "was not written by crackle". Empty if
/// there is none, or one of crackle, even if damaged. Not collective.
std::string obstacle(const std::filesystem::path& file);

/// Contents of an ensemble file, without the statistics, which follow from the samples.
struct EnsembleContent {
  std::string input_text;
  input::Sections sections;
  std::vector<analysis::SampleSummary> samples;
  geometry::MotherPoints base;  ///< empty if each sample has its own
};

/// Not collective. Results missing from an older file are as in a row without results.
/// @throws std::runtime_error when the file is not a complete ensemble file of oldest_schema_version or above
EnsembleContent read_ensemble(const std::filesystem::path& file);

/// The same, for this input only; the number of samples may differ. Not collective.
/// @throws std::runtime_error also when the file's input has different samples
EnsembleContent read_ensemble(const std::filesystem::path& file, const input::Parameters& parameters);

/// The base mother points alone. Not collective.
/// @throws std::runtime_error when the file is not a complete ensemble file of a readable version and this
///   input
geometry::MotherPoints read_mother_points(const std::filesystem::path& file,
                                          const input::Parameters& parameters);

}  // namespace crackle::io
