// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"
#include "crackle/ensemble/ensemble_run.h"
#include "crackle/input/reader.h"

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

/// Sweeps: the ensembles of several inputs, from one queue.
namespace crackle::ensemble {

/// The input of a sweep that its folder holds: folder/sweep.toml.
std::filesystem::path sweep_input(const std::filesystem::path& folder);

/// The folder of a case, an ensemble's folder like any other: folder/case-07 of 12 cases.
std::filesystem::path case_folder(const std::filesystem::path& folder, std::size_t number,
                                  std::size_t n_cases);

/// The table that a sweep leaves behind: folder/summary.csv.
std::filesystem::path sweep_table(const std::filesystem::path& folder);

/// Runs all cases. Samples are handed out in the order of their numbers, each of all cases before the next
/// one, so that cases with the same body can share its mesh; base mother points are made once for all cases
/// that have the same ones. Each case leaves what run_ensemble does; then the table is written. Collective
/// over `world`.
/// @param parameters with the sweep, which becomes sweep_input()
/// @param options of the run, for all cases; `folder` is the sweep's
/// @param mechanics of a sample of a case
/// @return the sums over all cases
/// @throws as run_ensemble; before anything is written when the folder holds something else
RunOutcome run_sweep(const parallel::Communicator& world, const input::Parameters& parameters,
                     const std::vector<input::Case>& cases, const RunOptions& options,
                     const std::function<SampleFunction(const input::Parameters&)>& mechanics);

/// The rows of one case.
struct CaseRows {
  const input::Case* of = nullptr;
  std::string folder;
  std::vector<analysis::SampleSummary> rows;
};

/// One line for each case: its settings, how many samples are done and failed, and of every result the mean
/// with its 95 % interval (Student's), or the share of samples with Wilson's; SI units. As CSV.
std::string sweep_csv(std::span<const CaseRows> cases);

/// The same of a few results, as a table to read.
std::string sweep_text(std::span<const CaseRows> cases);

}  // namespace crackle::ensemble
