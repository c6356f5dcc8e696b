// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace crackle::io {

/// Names of the objects and attributes in which two result files (samples or ensembles) differ, in
/// alphabetical order; empty if the files are equal. Values are compared bit by bit, so NaN equals NaN.
/// /timing and /provenance, which differ between runs, are excluded.
/// @throws std::runtime_error naming a file that cannot be read
std::vector<std::string> differences(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace crackle::io
