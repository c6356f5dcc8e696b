// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"
#include "crackle/analysis/statistics.h"
#include "crackle/input/parameters.h"
#include "crackle/parallel/communicator.h"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace crackle::io {

/// Rows first..first+rows.size() of the ensemble, written by one rank.
struct EnsembleBlock {
  std::size_t first = 0;
  std::vector<analysis::SampleSummary> rows;
};

/// Writes ensemble.h5 through MPI-IO; every rank writes its block of rows, all ranks take part in every
/// collective call, ranks without rows too. Written under another name and renamed when whole. Collective.
/// @param base mother points of the ensemble (root only; may be empty elsewhere)
/// @throws the same parallel::AgreedError on every rank
void write_ensemble(const parallel::Communicator& world, const std::filesystem::path& file,
                    const input::Parameters& parameters, const EnsembleBlock& block,
                    const analysis::Statistics& statistics);

/// What is stored in an ensemble file; not collective.
struct EnsembleContent {
  std::string input_text;
  std::vector<analysis::SampleSummary> samples;
  analysis::Statistics statistics;
};
EnsembleContent read_ensemble(const std::filesystem::path& file);

}  // namespace crackle::io
