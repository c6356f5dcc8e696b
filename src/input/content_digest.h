// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace crackle::input {

/// Number of bytes and 64-bit FNV-1a hash of a file's content, as text: tells contents apart that differ by
/// mistake, not by intent. Nothing when the file cannot be read.
std::optional<std::string> content_digest(const std::filesystem::path& file);

}  // namespace crackle::input
