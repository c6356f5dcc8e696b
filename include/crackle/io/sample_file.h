// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/crack_surface.h"
#include "crackle/analysis/sample_summary.h"
#include "crackle/dynamics/sample_result.h"
#include "crackle/geometry/realization.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace crackle::io {

/// Everything that goes into out/samples/NNNN.h5.
struct SampleFileContent {
  const input::Parameters& parameters;
  std::uint64_t sample;
  const geometry::Realization& realization;
  const dynamics::SampleResult& result;
  const analysis::CrackSurface& surface;
  const analysis::SampleSummary& summary;
};

/// out/samples/NNNN.h5
std::filesystem::path sample_path(const std::filesystem::path& folder, std::uint64_t sample);

/// Writes the file under another name, flushes it and renames it when it is whole. Not collective.
/// @throws std::runtime_error naming the file when anything cannot be written; no partial file is left
void write_sample(const std::filesystem::path& file, const SampleFileContent& content);

/// As write_sample, for a sample that failed: identity, status and reason only.
void write_failed_sample(const std::filesystem::path& file, const input::Parameters& parameters,
                         std::uint64_t sample, const analysis::SampleSummary& summary);

/// The sample's row. @throws std::runtime_error when the file is not a whole sample file of this input and
/// number
analysis::SampleSummary read_summary(const std::filesystem::path& file, const input::Parameters& parameters,
                                     std::uint64_t sample);

}  // namespace crackle::io
