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

/// Sweeps: ensembles of several inputs, run from one queue.
namespace crackle::ensemble {

/// The copy of the sweep's input: folder/sweep.toml.
std::filesystem::path sweep_input(const std::filesystem::path& folder);

/// The folder of a case, an ordinary ensemble folder: folder/case-07 of 12 cases.
std::filesystem::path case_folder(const std::filesystem::path& folder, std::size_t number,
                                  std::size_t n_cases);

/// The result table of a sweep: folder/summary.csv.
std::filesystem::path sweep_table(const std::filesystem::path& folder);

/// Runs all cases. Sample n of every case is handed out before sample n + 1, so that cases with the same body
/// can share its mesh; cases with the same base mother points share these. Each case produces the output of
/// run_ensemble; then the table is written. Collective over `world`.
/// @param parameters with the sweep, stored as sweep_input()
/// @param options of the run, for all cases; `folder` is the sweep's
/// @param mechanics of a sample of a case
/// @return the sums over all cases
/// @throws as run_ensemble; before anything is written if the folder has other contents
RunOutcome run_sweep(const parallel::Communicator& world, const input::Parameters& parameters,
                     const std::vector<input::Case>& cases, const RunOptions& options,
                     const std::function<SampleFunction(const input::Parameters&)>& mechanics);

/// The rows of one case.
struct CaseRows {
  const input::Case* of = nullptr;
  std::string folder;
  std::vector<analysis::SampleSummary> rows;
};

/// CSV with one line per case: its settings, the number of samples done and failed, and for every result the
/// mean with its 95 % interval (Student's t) or the share of samples with its interval (Wilson); SI units.
std::string sweep_csv(std::span<const CaseRows> cases);

/// A selection of these results as a readable table.
std::string sweep_text(std::span<const CaseRows> cases);

}  // namespace crackle::ensemble
