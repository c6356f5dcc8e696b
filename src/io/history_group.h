// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/crack_history.h"
#include "crackle/dynamics/sample_result.h"
#include "crackle/input/parameters.h"

#include "hdf5.h"

#include <vector>

namespace crackle::io {

/// Writes the group /history of a sample file: one row for each moment.
/// @param separated_at as in SampleResult
/// @param cracks of the same rows; empty tables without analysis
void write_history(hid_t file, const input::Parameters& parameters,
                   const std::vector<dynamics::HistoryRow>& rows, double separated_at,
                   const analysis::CrackHistory& cracks);

}  // namespace crackle::io
