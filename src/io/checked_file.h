// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

/// Files that end with a check sum of their bytes. Readers of the format before it do not mind the 32 bytes
/// behind its end.
namespace crackle::io {

/// Writes the file in one piece, with its check sum: as a whole, or not at all.
/// @throws std::runtime_error naming the file and the reason
void write_checked_file(const std::filesystem::path& file, std::vector<std::byte> bytes);

/// The bytes without the check sum.
/// @throws std::runtime_error with the reason when the file cannot be read, was cut short, changed or damaged
std::vector<std::byte> read_checked_file(const std::filesystem::path& file);

}  // namespace crackle::io
