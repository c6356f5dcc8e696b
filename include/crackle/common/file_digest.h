// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace crackle {

/// Size and 64-bit FNV-1a hash of a file's contents, as text: detects accidental, not deliberate differences.
/// Empty if the file cannot be read.
std::optional<std::string> file_digest(const std::filesystem::path& file);

}  // namespace crackle
