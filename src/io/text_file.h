// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

namespace crackle::io {

/// Writes a text atomically: under a temporary name, renamed when complete.
/// @throws std::runtime_error naming the file and the reason
void write_text_file(const std::filesystem::path& file, const std::string& text);

}  // namespace crackle::io
