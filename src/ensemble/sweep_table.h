// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/sample_summary.h"
#include "input/reader.h"

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

/// The folder of a sweep and its table of results.
namespace crackle::ensemble {

/// The copy of the sweep's input: folder/sweep.toml.
std::filesystem::path sweep_input(const std::filesystem::path& folder);

/// The folder of a case, an ordinary ensemble folder: folder/case-07 of 12 cases.
std::filesystem::path case_folder(const std::filesystem::path& folder, std::size_t number,
                                  std::size_t n_cases);

/// The result table of a sweep: folder/summary.csv.
std::filesystem::path sweep_table(const std::filesystem::path& folder);

/// Refuses a folder with other contents or with other cases.
/// @throws std::runtime_error with advice
void check_sweep_folder(const std::filesystem::path& folder, std::size_t n_cases, bool is_resumed);

/// The rows of one case.
struct CaseRows {
  const input::Case* of = nullptr;
  std::string folder;
  std::vector<analysis::SampleSummary> rows;
};

/// CSV with one line per case: its settings, the number of samples done and failed, and for every result the
/// mean with its 95 % interval (Student's t) or the share of samples with its interval (Wilson), by whole
/// draws of random inputs; SI units.
std::string sweep_csv(std::span<const CaseRows> cases);

/// A selection of these results as a readable table.
std::string sweep_text(std::span<const CaseRows> cases);

/// Those that say how samples broke as one JSON document, with how each is shown; NaN is null.
std::string sweep_json(std::span<const CaseRows> cases);

}  // namespace crackle::ensemble
